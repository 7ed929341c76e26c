"""Reports of stored studies: figures, HTML, PDF (`build`), the summary in git (`front_page`)."""
