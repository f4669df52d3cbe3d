"""Work in shards, over any executor: executors, checks, layout of the results, the folder of shards, merging."""
