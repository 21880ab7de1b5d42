import pickle
from pathlib import Path

from unstructured_mg.capture.frame_error import FrameError
from unstructured_mg.errors import UserError


def test_it_is_one_sentence_for_the_user_and_crosses_processes():
    error = pickle.loads(pickle.dumps(FrameError(Path("a/b.obj"), "it is empty", "export it again")))
    assert str(error) == "a/b.obj: it is empty; export it again." and isinstance(error, UserError)
    assert (error.file, error.fault, error.remedy) == (Path("a/b.obj"), "it is empty", "export it again")
