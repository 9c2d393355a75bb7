"""Reports: pages of figures, tables and words, from the templates beside this."""
