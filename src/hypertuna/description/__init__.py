"""One robot, described: schema, robot, validation, provenance, writer."""
