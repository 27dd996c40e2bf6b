"""The C interface through ctypes: what a client needs of it, in one page. CONTACT_PATCH_LIBRARY names the shared library."""

import ctypes as c
import os

library = c.CDLL(os.environ["CONTACT_PATCH_LIBRARY"])
library.cp_message.restype = c.c_char_p
library.cp_curve_new.argtypes = [c.c_char_p, c.c_char_p, c.c_double, c.c_double, c.c_int, c.c_int, c.POINTER(c.c_void_p)]
library.cp_curve_evaluate.argtypes = [c.c_void_p, c.c_double, c.POINTER(c.c_double), c.POINTER(c.c_double)]
library.cp_curve_free.argtypes = [c.c_void_p]
library.cp_contact_new.argtypes = [c.c_char_p, c.c_char_p, c.POINTER(c.c_void_p)]
library.cp_contact_free.argtypes = [c.c_void_p]


class Pose(c.Structure):
    _fields_ = [("depth", c.c_double), ("tilt", c.c_double * 2), ("at", c.c_double * 2)]


class Reaction(c.Structure):
    _fields_ = [("force", c.c_double), ("moment", c.c_double * 2), ("area", c.c_double), ("error", c.c_double), ("laid", c.c_int)]


library.cp_contact_step.argtypes = [c.c_void_p, c.POINTER(Pose), c.POINTER(Reaction), c.POINTER(c.c_double)]


def checked(status):
    if status:
        raise RuntimeError(library.cp_message().decode())


class Curve:
    """Force over depth of a scene."""

    def __init__(self, scene, accuracy):
        self.handle = c.c_void_p()
        checked(library.cp_curve_new(scene.encode(), None, accuracy, float("nan"), 0, 0, c.byref(self.handle)))

    def __call__(self, depth):
        force, stiffness = c.c_double(), c.c_double()
        checked(library.cp_curve_evaluate(self.handle, depth, c.byref(force), c.byref(stiffness)))
        return force.value, stiffness.value

    def __del__(self):
        library.cp_curve_free(self.handle)


class Contact:
    """A contact from pose to pose."""

    def __init__(self, scene):
        self.handle = c.c_void_p()
        checked(library.cp_contact_new(scene.encode(), None, c.byref(self.handle)))
        self.answer = Reaction()

    def __call__(self, depth, tilt=(0.0, 0.0), at=(0.0, 0.0), stiffness=None):
        pose = Pose(depth, (c.c_double * 2)(*tilt), (c.c_double * 2)(*at))
        checked(library.cp_contact_step(self.handle, c.byref(pose), c.byref(self.answer), stiffness))
        return self.answer

    def __del__(self):
        library.cp_contact_free(self.handle)
