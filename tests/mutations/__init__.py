"""Damaged input files, and what the commands that read them must make of each: an answer or one sentence.

`damage` changes a file by a seed; `cases` lists the kinds of files and their commands; `judge` runs a command as a user
does and tells what no user should meet. The long run is `validation/mutations/run.py`.
"""
