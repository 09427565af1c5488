// What sinew's own files say beyond glTF, in extras whose names begin with sinew_ (written by
// write*.cpp): vertex caches and how clips play them, animated visibility, lights without falloff,
// frame rate and surroundings. Foreign files may hold anything in their extras, of any type.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sinew/io/gltf/node.h"
#include "sinew/io/gltf/primitive.h"
#include "sinew/io/gltf/reader.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

// The vertex attribute that tells which vertices of a cached mesh are one point that was split for
// its attributes: the low and the high 16 bits of its number.
inline constexpr const char* kPointAttribute = "_SINEW_POINT";
// Marks a node whose scale shows (1) and hides (0) the one node below it.
inline constexpr const char* kVisibilityExtra = "sinew_visibility";
// Marks a channel that only keeps a clip of nothing but cache keys alive.
inline constexpr const char* kHoldExtra = "sinew_hold";

// The extras of an element; a view of nothing if it has none, or no object.
Json extras_of(const Json& json);
bool has_flag(const Json& json, const char* extra);

// Reads the vertex cache of a mesh whose other data are complete, if it has one.
Result<void> read_vertex_cache(const Reader& reader, const Json& json, const Primitives& primitives,
                               Mesh& mesh);

// Adds the clip's cache_key channels.
Result<void> read_cache_keys(const Reader& reader, const Json& json,
                             std::span<const NodePlace> places, const Scene& scene, Clip& clip);
// Sets the clip's extent where the file states it.
Result<void> read_extent(const Json& json, Clip& clip);

// Frame rate, number of frames, surroundings. `json` is the scene.
Result<void> read_scene_extras(const Json& json, Scene& scene);

}  // namespace sinew::gltf
