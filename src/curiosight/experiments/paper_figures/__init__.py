"""What the paper's figures show, of any source, as numbers and pictures to be drawn."""
