"""The shape descriptors by name."""

from unstructured_mg.matching import cylindrical_edt, deformation_gradients, shape_histogram
from unstructured_mg.matching.descriptor import Descriptor

DESCRIPTORS: dict[str, Descriptor] = {
    "cylindrical_edt": cylindrical_edt.DESCRIPTOR,
    "shape_histogram": shape_histogram.DESCRIPTOR,
    "deformation_gradients": deformation_gradients.DESCRIPTOR,
}
