"""Mission files, flights, records, logs, GPX, upload."""
