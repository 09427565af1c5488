// Based on: Wavefront, "MTL material format (Lightwave, OBJ)", Alias|Wavefront, 1995, and the
// statements for physically based shading (Pr, Pm, Ke, norm) that exporters agreed on since.
#include "sinew/io/obj/mtl.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "sinew/io/obj/text.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

constexpr size_t kMostMaterials = 1 << 20;

// Statements without a meaning here: ambient colour, refraction, sharpness of reflections.
constexpr std::string_view kMeaningless[] = {"Ka", "map_Ka", "Ni", "sharpness"};

class Parser {
 public:
  Parser(std::string_view text, const std::string& path, bool strict)
      : lines_(text), path_(path), strict_(strict) {}

  Result<std::vector<MtlMaterial>> run(std::vector<std::string>& warnings) {
    std::string_view line;
    while (lines_.next(line)) {
      ObjWords words(line);
      if (!words.at_end()) SINEW_CHECKED(read_statement(words.word(), words));
    }
    ignored_.append_warnings(path_ + ": ", warnings);
    return std::move(materials_);
  }

 private:
  tl::unexpected<Error> error(std::string problem, std::string remedy = "") const {
    return fail({ErrorKind::bad_input, path_, fmt::format("line {}", lines_.number()),
                 std::move(problem), std::move(remedy)});
  }

  Result<void> read_statement(std::string_view name, ObjWords words);
  Result<void> read_map(std::string_view name, ObjWords words, MtlTexture& out);
  Result<void> read_option(std::string_view option, ObjWords& words, MtlTexture& out);
  Result<void> ignore(std::string_view name);

  Result<float> number(ObjWords words) {
    float value = 0.0f;
    const auto count = take_numbers(words, {&value, 1}, 1);
    if (!count) return error(count.error());
    return value;
  }
  // One number means a grey.
  Result<vec3> color(ObjWords words) {
    std::array<float, 3> value{};
    const auto count = take_numbers(words, value, 1);
    if (!count) return error(count.error());
    if (*count == 2) return error("a colour cannot have 2 numbers");
    return *count == 1 ? vec3(value[0]) : vec3(value[0], value[1], value[2]);
  }

  ObjLines lines_;
  const std::string& path_;
  const bool strict_;
  std::vector<MtlMaterial> materials_;
  IgnoredStatements ignored_;
};

Result<void> Parser::ignore(std::string_view name) {
  if (strict_) {
    return error(fmt::format("statement \"{}\" is not supported", printable(name)),
                 "load it without strict");
  }
  if (!ignored_.add(name, lines_.number())) {
    return error(fmt::format("\"{}\" is one unknown statement too many", printable(name)),
                 "give a material library");
  }
  return {};
}

Result<void> Parser::read_statement(std::string_view name, ObjWords words) {
  if (name == "newmtl") {
    if (materials_.size() >= kMostMaterials) return error("has too many materials");
    materials_.emplace_back().name = std::string(words.rest());
    return {};
  }
  if (materials_.empty()) return error("comes before the first newmtl", "give a material library");
  MtlMaterial& material = materials_.back();

  const bool is_color = name == "Kd" || name == "Ks" || name == "Ke";
  if (is_color && (words.rest().starts_with("spectral") || words.rest().starts_with("xyz"))) {
    return ignore(std::string(name) + (words.rest()[0] == 's' ? " spectral" : " xyz"));
  }
  if (name == "Kd") {
    SINEW_TRY(material.diffuse, color(words));
  } else if (name == "Ks") {
    SINEW_TRY(material.specular, color(words));
  } else if (name == "Ke") {
    SINEW_TRY(material.emission, color(words));
  } else if (name == "Ns") {
    SINEW_TRY(material.exponent, number(words));
  } else if (name == "d") {
    if (words.rest().starts_with("-halo")) words.word();
    SINEW_TRY(material.opacity, number(words));
  } else if (name == "Tr") {
    SINEW_TRY(const float transparency, number(words));
    material.opacity = 1.0f - transparency;
  } else if (name == "illum") {
    SINEW_TRY(const float illum, number(words));
    if (!(illum >= 0.0f && illum <= 10.0f)) return error("illum must be 0 to 10");
    material.illum = static_cast<int>(illum);
  } else if (name == "Pr") {
    SINEW_TRY(material.roughness, number(words));
  } else if (name == "Pm") {
    SINEW_TRY(material.metallic, number(words));
  } else if (name == "map_Kd") {
    return read_map(name, words, material.diffuse_map);
  } else if (name == "map_d") {
    return read_map(name, words, material.opacity_map);
  } else if (name == "map_Ke") {
    return read_map(name, words, material.emission_map);
  } else if (name == "map_Bump" || name == "map_bump" || name == "bump") {
    return read_map(name, words, material.bump_map);
  } else if (name == "norm" || name == "map_Kn") {
    return read_map(name, words, material.normal_map);
  } else if (std::find(std::begin(kMeaningless), std::end(kMeaningless), name) ==
             std::end(kMeaningless)) {
    return ignore(name);
  }
  return {};
}

// "-option value ... file name": the name is the rest of the line and may hold blanks.
Result<void> Parser::read_map(std::string_view name, ObjWords words, MtlTexture& out) {
  out = MtlTexture{};
  out.line = lines_.number();
  while (words.rest().starts_with('-')) SINEW_CHECKED(read_option(words.word(), words, out));
  out.file = std::string(words.rest());
  std::replace(out.file.begin(), out.file.end(), '\\', '/');
  if (out.file.empty()) return error(std::string(name) + " names no file");
  return {};
}

Result<void> Parser::read_option(std::string_view option, ObjWords& words, MtlTexture& out) {
  if (option == "-s" || option == "-o" || option == "-t") {  // one to three numbers
    vec3 value(option == "-s" ? 1.0f : 0.0f);
    for (int i = 0; i < 3; ++i) {
      const ObjNumber number = words.number(value[i]);
      if (number == ObjNumber::not_finite || (i == 0 && number == ObjNumber::none)) {
        return error(std::string(option) + " needs a finite number");
      }
      if (number == ObjNumber::none) break;
    }
    if (option == "-s") out.scale = vec2(value);
    if (option == "-o") out.offset = vec2(value);
    return option == "-t" ? ignore("map option -t") : Result<void>{};
  }
  if (option == "-bm") {
    if (words.number(out.bump_scale) != ObjNumber::ok) return error("-bm needs a finite number");
    return {};
  }
  if (option == "-clamp") {
    out.clamp = words.word() == "on";
    return {};
  }
  const bool two_values = option == "-mm";
  const bool known = two_values || option == "-blendu" || option == "-blendv" || option == "-cc" ||
                     option == "-texres" || option == "-imfchan" || option == "-boost" ||
                     option == "-type";
  if (!known) return error(fmt::format("\"{}\" is no option of a map", printable(option)));
  words.word();
  if (two_values) words.word();
  return option == "-blendu" || option == "-blendv" ? Result<void>{}
                                                    : ignore("map option " + std::string(option));
}

}  // namespace

Result<std::vector<MtlMaterial>> parse_mtl(std::string_view text, const std::string& path,
                                           bool strict, std::vector<std::string>& warnings) {
  return Parser(text, path, strict).run(warnings);
}

}  // namespace sinew
