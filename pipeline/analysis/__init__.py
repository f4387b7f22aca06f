"""Results of a stored sweep: labelled dataset, boundary, band and inference."""
