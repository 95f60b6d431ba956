"""The experiments of the three sources, one file a table or figure, beside ours: `burnish reproduce`."""
