"""Tables and other text: a row, or some rows, a sample."""
