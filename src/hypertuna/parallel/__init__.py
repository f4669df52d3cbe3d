"""Work in shards, over any executor: executors, layout of the results, the folder of shards, merging."""
