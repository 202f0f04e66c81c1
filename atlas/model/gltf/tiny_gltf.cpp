// SPDX-License-Identifier: GPL-3.0-or-later
// The one translation unit that holds tinygltf's code, which is a header.
#define TINYGLTF_IMPLEMENTATION
#include "atlas/model/gltf/tiny_gltf.h"
