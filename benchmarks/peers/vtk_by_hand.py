"""NumPy by hand and VTK's flying edges."""

import numpy as np
import specimen
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

PACKAGES = ("vtk", "numpy")


def run() -> "vtk.vtkPolyData":
    image = vtk.vtkImageData()
    image.SetDimensions(*specimen.SHAPE[::-1])  # VTK counts x fastest: the part comes out mirrored
    image.SetSpacing(*specimen.SPACING[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(specimen.separable(specimen.axes()).ravel()))
    edges = vtk.vtkFlyingEdges3D()
    edges.SetInputData(image)
    edges.SetValue(0, 0.0)
    edges.ComputeNormalsOff()
    edges.Update()
    return edges.GetOutput()


def arrays(mesh: "vtk.vtkPolyData") -> "tuple[np.ndarray, np.ndarray]":
    corners = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return vtk_to_numpy(mesh.GetPoints().GetData())[:, ::-1], corners
