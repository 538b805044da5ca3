// SPDX-License-Identifier: GPL-3.0-or-later
// A Python interpreter as an executable of its own. Linked with the libraries of a bpy wheel, it has them in the global
// scope, as Blender's executable does; the wheel itself loads them privately, so that clashes of symbols do not show.
#include <Python.h>

int main(int argc, char** argv) { return Py_BytesMain(argc, argv); }
