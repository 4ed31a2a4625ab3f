"""A file of another tester as a table of cells: text, Excel or TDMS."""
