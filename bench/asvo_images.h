// Part `images`: how far pictures of voxels are from the ray traced triangles they stand for.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/asvo.h"
#include "bench/asvo_body.h"

namespace sinew::bench {

// Rows "asvo_image": PSNR and FLIP of all methods in frames of the first clip, every method with
// the lattice's shadow maps. `pictures` gets the first frame of each as HTML.
Result<void> measure_images(const AsvoBody& body, const AsvoOptions& options, nlohmann::json& rows,
                            std::string& pictures);

}  // namespace sinew::bench
