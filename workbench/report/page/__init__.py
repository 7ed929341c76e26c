"""Pages: what is said, as Markdown, and its printers.

`markdown` writes blocks, `page` fills the templates of chapters, `reading` parses; `terminal` and
`documents` (HTML, PDF, Markdown of git hosts) print. `formatting` turns numbers into text,
`bibliography` holds the works that texts cite. Each imports its library only then.
"""
