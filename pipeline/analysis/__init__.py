"""What a stored sweep says: labelled dataset, boundary, band and inference."""
