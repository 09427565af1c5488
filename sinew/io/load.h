// Reads scenes from files: glTF 2.0 and GLB, OBJ and PLY, sequences of them, PC2 and MDD vertex
// caches over them, BART's AFF, MagicaVoxel's voxels, octrees of our own, and the project's own
// study scenes.
#pragma once

#include <cstdint>
#include <string>

#include "sinew/base/error.h"
#include "sinew/scene/scene.h"

namespace sinew {

struct LoadOptions {
  bool strict = false;                        // unsupported features are errors, not warnings
  uint64_t memory_limit = uint64_t{8} << 30;  // bytes that loading may take; more is an error
  // Bytes that the octrees of a .svo file may take: details of blocks come from the file as they
  // are seen, and go again (svo/file/stream.h). The file must stay. 0: octrees are read as a whole.
  uint64_t voxel_memory = 0;
  bool settle = true;  // with voxel_memory: pictures wait for what they show
};

// `input` is one of
//   model.gltf, model.glb
//   model.obj, model.ply         one static mesh
//   walk_####.obj, walk_%04d.ply a sequence: one file a frame (a vertex cache if topology agrees)
//   base.obj+positions.pc2       a vertex cache (PC2 or MDD) over a base mesh (OBJ or PLY); it may
//                                lie beside the mesh
//   scene.aff                    BART's animated file format
//   aff:complexity=8,museum5.aff ... with its animated triangles split into 4^8
//   walk.svo                     octrees and the scene around them, see io/svo/svo.h
//   castle.vox                   MagicaVoxel's models, see io/vox/vox.h
//   study:NAME[,key=value...]    see scene/study.h
// Files that a file refers to must lie in its own folder or below it; the textures of an AFF file
// may also lie in a folder TextureFiles beside its own, as BART has them. The scene that comes back
// is valid (validate() finds nothing); whatever was unsupported is named in Scene::warnings.
Result<Scene> load(const std::string& input, const LoadOptions& options = {});

}  // namespace sinew
