"""Files of all rooms.

files (CSV, NetCDF, atomic writing, shipped files), tables (reading CSV), checkpoint (journal of long work),
mcap (logs), extras (optional packages), quantity (a number of a result with unit and label).
"""
