// What all parts of the glTF writer share.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "sinew/io/gltf/warnings.h"
#include "sinew/io/gltf/write_asset.h"
#include "sinew/scene/scene.h"

namespace sinew::gltf {

using JsonOut = nlohmann::ordered_json;

struct WriteContext {
  const Scene& scene;
  AssetWriter& asset;
  Warnings& warnings;
  bool embedded = false;  // in a file of our own, that only we read and that has the octrees which
                          // nodes name; see embed.h
};

// What warnings call an element.
inline std::string element(const char* kind, const std::string& name) {
  return kind + (name.empty() ? std::string() : " '" + name + "'");
}

inline JsonOut named(const std::string& name) {
  JsonOut json = JsonOut::object();
  if (!name.empty()) json["name"] = name;
  return json;
}

// An array of the vector's components; double holds a float's digits.
template <class T>
JsonOut json_of(const T& vector) {
  JsonOut json = JsonOut::array();
  for (int k = 0; k < T::length(); ++k) json.push_back(double{vector[k]});
  return json;
}

}  // namespace sinew::gltf
