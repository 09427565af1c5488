#include "bench/tsah_paper.h"

#include <algorithm>
#include <array>

namespace sinew::bench {
namespace {

constexpr std::array kTable1 = {
    PaperCost{"robots", "BART Robots", true, "SAH-rebuild", 24.7, 56, 57},
    PaperCost{"robots", "BART Robots", true, "SAH*", 18.5, 57, 58},
    PaperCost{"robots", "BART Robots", true, "SAH0", 0.4, 69, 71},
    PaperCost{"robots", "BART Robots", true, "T-SAH k=0", 1.9, 57, 57},
    PaperCost{"robots", "BART Robots", true, "T-SAH k=2", 1.9, 57, 57},
    PaperCost{"robots", "BART Robots", true, "T-SAH k=4", 2.0, 57, 57},
    PaperCost{"kitchen", "BART Kitchen", true, "SAH-rebuild", 41.6, 26, 26},
    PaperCost{"kitchen", "BART Kitchen", true, "SAH*", 32.6, 26, 26},
    PaperCost{"kitchen", "BART Kitchen", true, "SAH0", 0.7, 37, 38},
    PaperCost{"kitchen", "BART Kitchen", true, "T-SAH k=0", 3.6, 26, 26},
    PaperCost{"kitchen", "BART Kitchen", true, "T-SAH k=2", 3.7, 26, 26},
    PaperCost{"kitchen", "BART Kitchen", true, "T-SAH k=4", 3.7, 26, 26},
    PaperCost{"museum", "BART Museum", true, "SAH-rebuild", 39.7, 40, 148},
    PaperCost{"museum", "BART Museum", true, "SAH*", 18.6, 364, 1376},
    PaperCost{"museum", "BART Museum", true, "SAH0", 0.4, 1558, 2335},
    PaperCost{"museum", "BART Museum", true, "T-SAH k=0", 123, 119, 365},
    PaperCost{"museum", "BART Museum", true, "T-SAH k=2", 155, 136, 282},
    PaperCost{"museum", "BART Museum", true, "T-SAH k=4", 161, 149, 266},
    PaperCost{"cloth", "Cloth Ball", false, "SAH-rebuild", 22.9, 73, 91},
    PaperCost{"cloth", "Cloth Ball", false, "SAH*", 20.8, 97, 156},
    PaperCost{"cloth", "Cloth Ball", false, "SAH0", 0.4, 97, 156},
    PaperCost{"cloth", "Cloth Ball", false, "T-SAH k=0", 9.0, 90, 139},
    PaperCost{"cloth", "Cloth Ball", false, "T-SAH k=2", 9.7, 90, 129},
    PaperCost{"cloth", "Cloth Ball", false, "T-SAH k=4", 0.6, 98, 147},
    PaperCost{"cell24", "24 Cell", false, "SAH-rebuild", 49.2, 111, 120},
    PaperCost{"cell24", "24 Cell", false, "SAH*", 28.6, 161, 181},
    PaperCost{"cell24", "24 Cell", false, "SAH0", 0.5, 195, 250},
    PaperCost{"cell24", "24 Cell", false, "T-SAH k=0", 13.1, 131, 142},
    PaperCost{"cell24", "24 Cell", false, "T-SAH k=2", 13.5, 131, 142},
    PaperCost{"cell24", "24 Cell", false, "T-SAH k=4", 13.5, 131, 141},
    PaperCost{"fracture", "Dragon Bunny", false, "SAH-rebuild", 112, 57, 134},
    PaperCost{"fracture", "Dragon Bunny", false, "SAH*", 25.8, 474, 1441},
    PaperCost{"fracture", "Dragon Bunny", false, "SAH0", 1.4, 1542, 2865},
    PaperCost{"fracture", "Dragon Bunny", false, "T-SAH k=0", 13.2, 137, 365},
    PaperCost{"fracture", "Dragon Bunny", false, "T-SAH k=2", 34.0, 102, 220},
    PaperCost{"fracture", "Dragon Bunny", false, "T-SAH k=4", 28.7, 103, 190},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "SAH-rebuild", 912, 555, 644},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "SAH*", 460, 747, 907},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "SAH0", 12.2, 1530, 3801},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "T-SAH k=0", 116, 571, 658},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "T-SAH k=2", 116, 567, 647},
    PaperCost{"fracture-1600k", "Breaking Lion", false, "T-SAH k=4", 120, 566, 640},
};

}  // namespace

const PaperCost* paper_cost(std::string_view scene, std::string_view method) {
  const auto found = std::ranges::find_if(
      kTable1, [&](const PaperCost& p) { return p.scene == scene && p.method == method; });
  return found == kTable1.end() ? nullptr : &*found;
}

}  // namespace sinew::bench
