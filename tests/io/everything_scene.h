// A small scene made by hand that has everything a Scene can have, much of it in the form that is
// hardest to write: sheared and flattened nodes, seams, mixed shading, more than four influences,
// joints in several trees, one node bound twice, clips before time 0, caches, programs.
#pragma once

#include "sinew/scene/scene.h"

namespace sinew::test {

Scene everything_scene();

}  // namespace sinew::test
