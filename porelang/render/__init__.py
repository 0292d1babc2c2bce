"""Pictures of parts: the generated fragment shader, off screen, with field planes laid over it on the host.

`camera` is where one stands, `cells` what is known of the field in each cell of the box, `march` runs the shader tile
by tile, `frame` has the part fill the picture, `planes` and `painting` colour fields and outputs, `marks` and `legend`
write on it, `picture` puts them together as `wishes` say.
"""

from porelang.picture import Picture, write_png
from porelang.render.camera import Camera, look
from porelang.render.picture import render_output
from porelang.render.wishes import Wishes

__all__ = ["Camera", "Picture", "Wishes", "look", "render_output", "write_png"]
