#include "app/tree_option.h"

#include "sinew/io/output_file.h"

namespace sinew::app {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 36;

}  // namespace

Result<TreeFile> read_trees(const std::string& file, const Scene& scene, int clip) {
  SINEW_TRY(const std::string bytes, read_file(file, kMostBytes));
  const auto in_file = [&](Error error) {
    error.file = file;
    return fail(std::move(error));
  };
  Result<TreeFile> trees =
      decode_trees({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  if (!trees) return in_file(std::move(trees).error());
  if (auto fits = check_trees(*trees, scene, clip); !fits) return in_file(std::move(fits).error());
  return trees;
}

}  // namespace sinew::app
