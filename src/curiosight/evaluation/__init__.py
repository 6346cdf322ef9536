"""How good a model is, against ground truth or the teacher (sec. III)."""
