"""Reports of stored studies: figures, HTML, PDF and the summary in git (`build`)."""
