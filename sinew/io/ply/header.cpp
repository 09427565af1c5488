#include "sinew/io/ply/header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

#include "sinew/io/obj/text.h"
#include "sinew/io/text.h"

namespace sinew {
namespace {

// Both the original names and those that say the size.
constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames = {{
    {"char", PlyType::i8},
    {"int8", PlyType::i8},
    {"uchar", PlyType::u8},
    {"uint8", PlyType::u8},
    {"short", PlyType::i16},
    {"int16", PlyType::i16},
    {"ushort", PlyType::u16},
    {"uint16", PlyType::u16},
    {"int", PlyType::i32},
    {"int32", PlyType::i32},
    {"uint", PlyType::u32},
    {"uint32", PlyType::u32},
    {"float", PlyType::f32},
    {"float32", PlyType::f32},
    {"double", PlyType::f64},
    {"float64", PlyType::f64},
}};

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  Result<PlyHeader> run();

 private:
  tl::unexpected<Error> error(std::string problem, std::string remedy = "") const {
    return fail({ErrorKind::bad_input, path_, fmt::format("line {}", line_), std::move(problem),
                 std::move(remedy)});
  }
  bool next(std::string_view& line);
  Result<void> read_format(ObjWords words);
  Result<void> read_element(ObjWords words);
  Result<void> read_property(ObjWords words);
  void read_comment(ObjWords words);
  Result<PlyType> read_type(ObjWords& words) const;

  std::string_view bytes_;
  const std::string& path_;
  PlyHeader header_;
  std::string_view line_end_;  // as after "ply": the body may begin with any byte
  uint64_t line_ = 0;
};

bool HeaderParser::next(std::string_view& line) {
  const size_t end = bytes_.find(line_end_, header_.size);
  if (end == std::string_view::npos) return false;
  line = bytes_.substr(header_.size, end - header_.size);
  header_.size = end + line_end_.size();
  ++line_;
  return true;
}

Result<PlyHeader> HeaderParser::run() {
  for (const std::string_view end : {"\r\n", "\n", "\r"}) {
    if (line_end_.empty() && bytes_.substr(3).starts_with(end)) line_end_ = end;
  }
  bool has_format = false;
  std::string_view line;
  next(line);  // "ply"
  while (next(line)) {
    ObjWords words(line);
    const std::string_view statement = words.word();
    if (statement == "end_header") {
      if (!has_format) return error("the header names no format");
      return std::move(header_);
    }
    if (statement == "format") {
      SINEW_CHECKED(read_format(words));
      has_format = true;
    } else if (statement == "element") {
      SINEW_CHECKED(read_element(words));
    } else if (statement == "property") {
      SINEW_CHECKED(read_property(words));
    } else if (statement == "comment") {
      read_comment(words);
    } else if (statement != "obj_info" && !statement.empty()) {
      return error(fmt::format("\"{}\" does not belong into a header", printable(statement)));
    }
  }
  return error("the header is cut off: it has no end_header", "check that the file is complete");
}

Result<void> HeaderParser::read_format(ObjWords words) {
  const std::string_view format = words.word();
  if (format == "ascii") {
    header_.format = PlyFormat::ascii;
  } else if (format == "binary_little_endian") {
    header_.format = PlyFormat::little_endian;
  } else if (format == "binary_big_endian") {
    header_.format = PlyFormat::big_endian;
  } else {
    return error(fmt::format("the format \"{}\" is not known", printable(format)));
  }
  const std::string_view version = words.word();
  if (version != "1.0") {
    return error(fmt::format("version \"{}\" is not supported, 1.0 is", printable(version)));
  }
  return {};
}

Result<void> HeaderParser::read_element(ObjWords words) {
  PlyElement element;
  element.name = words.word();
  const std::string_view count = words.word();
  const char* const end = count.data() + count.size();
  const auto [stop, problem] = std::from_chars(count.data(), end, element.count);
  if (element.name.empty() || problem != std::errc() || stop != end || count.empty()) {
    return error("an element needs a name and a count");
  }
  for (const PlyElement& other : header_.elements) {
    if (other.name == element.name) {
      return error(fmt::format("element \"{}\" stands twice", printable(element.name)));
    }
  }
  if (header_.elements.size() >= 64) return error("has more than 64 elements");
  header_.elements.push_back(std::move(element));
  return {};
}

Result<PlyType> HeaderParser::read_type(ObjWords& words) const {
  const std::string_view name = words.word();
  for (const auto& [known, type] : kTypeNames) {
    if (name == known) return type;
  }
  return error(fmt::format("\"{}\" is not a type", printable(name)));
}

Result<void> HeaderParser::read_property(ObjWords words) {
  if (header_.elements.empty()) return error("a property stands before the first element");
  PlyElement& element = header_.elements.back();
  PlyProperty property;
  ObjWords after = words;
  if (after.word() == "list") {
    words = after;
    SINEW_TRY(property.count_type, read_type(words));
    if (*property.count_type == PlyType::f32 || *property.count_type == PlyType::f64) {
      return error("the length of a list must be an integer");
    }
  }
  SINEW_TRY(property.type, read_type(words));
  property.name = words.rest();
  if (property.name.empty()) return error("a property has no name");
  if (element.properties.size() >= 1024) return error("has more than 1024 properties");
  element.properties.push_back(std::move(property));
  return {};
}

void HeaderParser::read_comment(ObjWords words) {
  if (words.word() != "TextureFile" || words.rest().empty()) return;
  header_.textures.emplace_back(words.rest());
}

}  // namespace

uint32_t size_of(PlyType type) {
  switch (type) {
    case PlyType::i8:
    case PlyType::u8:
      return 1;
    case PlyType::i16:
    case PlyType::u16:
      return 2;
    case PlyType::i32:
    case PlyType::u32:
    case PlyType::f32:
      return 4;
    case PlyType::f64:
      break;
  }
  return 8;
}

int PlyElement::find(std::string_view property, bool list) const {
  for (size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == property && properties[i].count_type.has_value() == list) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

uint64_t PlyElement::least_row(PlyFormat format) const {
  if (format == PlyFormat::ascii) return 2 * properties.size();  // a digit and a blank each
  uint64_t size = 0;
  for (const PlyProperty& property : properties) {
    size += size_of(property.count_type.value_or(property.type));
  }
  return size;
}

Result<PlyHeader> parse_ply_header(std::string_view bytes, const std::string& path) {
  const bool is_ply =
      bytes.size() > 3 && bytes.starts_with("ply") && (bytes[3] == '\n' || bytes[3] == '\r');
  if (!is_ply) return fail({ErrorKind::bad_input, path, "", "is no PLY file", "give a PLY file"});
  return HeaderParser(bytes, path).run();
}

}  // namespace sinew
