"""Tools of every package: errors, files, ranges of numbers, work sent to threads and processes."""
