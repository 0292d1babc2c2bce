"""What a notebook shows: a viewer of the part where widgets run, a still picture where they do not, slices of fields.

`widget` is the viewer, an anywidget of which `widget.js` is the part in the browser; `display` is what stands under a
cell. Nothing here is imported before something is displayed, and none of it is needed for anything else.
"""
