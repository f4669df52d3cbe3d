"""The program `hypertuna`: one module for each command or group of commands.

main: the table of commands, imported when called, and the exit codes. environment: variables of the shell that
libraries read. options: the options that commands share, and how options are declared; parsing: what is typed, as
values; gait, search: the options of a gait, of a search for gaits.
emit: a result as JSON, tables, data and figure; console: JSON, tables, progress on the terminal.
"""
