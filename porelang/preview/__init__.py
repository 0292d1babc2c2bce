"""The live preview: a page on this machine that draws a program while it is written.

`scene` says what a page needs to draw an output; `live` follows a file and its settings; `server` serves them to one
browser, and to nobody else; `web/` is the page. The picture is drawn by the shader that `pore render` uses
(shaders/march.frag), on the viewer's own graphics.
"""
