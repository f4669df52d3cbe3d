"""Files of all rooms.

door (reading files of others), files (CSV, NetCDF, atomic writing, shipped files), tables (reading CSV), checkpoint
(journal of long work), mcap (logs), extras (optional packages), quantity (a number of a result with unit and label).
"""
