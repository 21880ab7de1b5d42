"""A capture made by code: a textured figure, meshed anew in every frame, with true correspondence known."""

from unstructured_mg.capture.procedural.choreography import Action
from unstructured_mg.capture.procedural.figure import ProceduralCapture, ProceduralFrame
from unstructured_mg.capture.procedural.motion import Motion
from unstructured_mg.capture.procedural.write import write_procedural

__all__ = ["Action", "Motion", "ProceduralCapture", "ProceduralFrame", "write_procedural"]
