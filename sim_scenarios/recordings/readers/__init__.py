"""A file a format: each reads what it is the reader of, and knows nothing of the others."""
