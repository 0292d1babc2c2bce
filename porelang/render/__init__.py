"""Pictures of parts: the generated fragment shader, off screen, with field planes laid over it on the host.

`camera` is where one stands, `cells` what is known of the field in each cell of the box, `march` runs the shader tile
by tile, `planes` colours fields on planes, `picture` puts them together.
"""

from porelang.render.camera import Camera, look
from porelang.render.picture import Picture, Wishes, render_output, write_png

__all__ = ["Camera", "Picture", "Wishes", "look", "render_output", "write_png"]
