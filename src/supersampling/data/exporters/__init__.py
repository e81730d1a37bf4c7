"""Writers of the capture layouts that `supersampling.data.readers` reads (`exporting`)."""
