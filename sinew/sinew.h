// The front door: include this one header.
#pragma once

#include "sinew/bvh/bvh.h"
#include "sinew/bvh/frames/optimize.h"
#include "sinew/io/image_file.h"
#include "sinew/io/load.h"
#include "sinew/io/movie.h"
#include "sinew/io/save.h"
#include "sinew/io/svo/svo.h"
#include "sinew/render/frame.h"
#include "sinew/render/voxelize_scene.h"
#include "sinew/scene/sample.h"
#include "sinew/scene/study.h"
#include "sinew/world/animation_trees.h"
#include "sinew/world/world.h"
