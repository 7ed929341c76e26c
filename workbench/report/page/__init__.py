"""What is said, apart from how it looks: the content tree and its four renderers.

`tree` holds the blocks, `formatting` turns numbers into text, `bibliography` the works that texts
cite. `terminal`, `markdown`, `html` and `typst` render a tree; each imports its library only then.
"""
