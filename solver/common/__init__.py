"""What every package uses: errors, files, ranges of numbers, work sent to threads and processes."""
