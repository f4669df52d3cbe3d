"""Reading and writing of files, for all rooms.

door (opening users' files), files (CSV, NetCDF, atomic writing, shipped files), tables (reading CSV), checkpoint
(journal of long work), mcap (logs), bags (messages of ROS 2), hdf5, hdf5_child (HDF5, in a process of its own), matlab
(MATLAB's files), extras (optional packages), quantity (a number of a result with unit and label).
"""
