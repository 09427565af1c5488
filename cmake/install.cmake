# What `cmake --install` and `cpack` make: the program; the library with its headers, a CMake package
# and a pkg-config file. Two components, and two Debian packages: sinew and libsinew-dev.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Every header that a user may include, and those that they include. They need glm, tl::expected and
# the standard library.
target_sources(sinew PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES
  sinew/sinew.h
  sinew/base/buffer.h sinew/base/error.h sinew/base/parallel.h sinew/base/work_time.h
  sinew/math/affine.h sinew/math/box.h sinew/math/ray.h sinew/math/vec.h
  sinew/motion/clusters.h sinew/motion/influences.h sinew/motion/motion.h sinew/motion/pose.h
  sinew/bvh/bounds.h sinew/bvh/bvh.h sinew/bvh/cost.h sinew/bvh/tree.h sinew/bvh/wide.h
  sinew/bvh/builders/build.h sinew/bvh/frames/frame_choice.h sinew/bvh/frames/frames.h
  sinew/bvh/frames/optimize.h sinew/bvh/frames/segments.h sinew/bvh/frames/tree_file.h
  sinew/bvh/trace/proximity.h sinew/bvh/trace/traverse.h sinew/bvh/update/choose.h
  sinew/bvh/update/update.h sinew/bvh/update/update_local.h
  sinew/svo/format.h sinew/svo/posed.h sinew/svo/voxel_at.h sinew/svo/draw/rasterize.h
  sinew/svo/draw/visibility.h sinew/svo/file/file.h sinew/svo/make/fragments.h
  sinew/svo/make/make_svo.h sinew/svo/make/voxelize.h
  sinew/scene/clip.h sinew/scene/image.h sinew/scene/material.h sinew/scene/mesh.h
  sinew/scene/sample.h sinew/scene/scene.h sinew/scene/study.h
  sinew/io/image_file.h sinew/io/load.h sinew/io/movie.h sinew/io/output_file.h sinew/io/save.h
  sinew/io/svo/svo.h sinew/io/vox/vox.h
  sinew/world/animation_trees.h sinew/world/voxel_bodies.h sinew/world/world.h
  sinew/render/attributes.h sinew/render/camera.h sinew/render/frame.h sinew/render/gbuffer.h
  sinew/render/layers.h sinew/render/lights.h sinew/render/raster_view.h sinew/render/refinement.h
  sinew/render/texture.h sinew/render/views.h sinew/render/voxelize_scene.h
  sinew/render/voxels/kept_voxels.h sinew/render/voxels/voxel_batch.h
  sinew/render/voxels/voxel_frame.h
  sinew/render/voxels/voxel_material.h sinew/render/voxels/voxel_settings.h
  sinew/render/voxels/voxel_shade.h sinew/render/voxels/voxel_shadows.h)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/sinew)
install(TARGETS sinew EXPORT sinewTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev
  INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT sinewTargets NAMESPACE sinew:: DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(cmake/sinewConfig.cmake.in sinewConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(sinewConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sinewConfig.cmake ${PROJECT_BINARY_DIR}/sinewConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT dev)

# These two have no pkg-config files of their own, or ones without their library.
set(sinew_decoders "")
if(draco_FOUND)
  string(APPEND sinew_decoders " -ldraco")
endif()
if(meshoptimizer_FOUND)
  string(APPEND sinew_decoders " -lmeshoptimizer")
endif()
# Relative, so that the file is right wherever it is installed to.
file(RELATIVE_PATH sinew_pc_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/sinew.pc.in sinew.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/sinew.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

install(TARGETS sinew_app RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
install(FILES LICENSE CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
install(DIRECTORY examples/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples COMPONENT dev)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR "The sinew authors")
set(CPACK_PACKAGE_CONTACT "The sinew authors <sinew@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGE_FILE_NAME sinew-${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program dev)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS OFF)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME sinew)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_DEV_PACKAGE_NAME libsinew-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS
    "libglm-dev, libexpected-dev, libtbb-dev, libhwy-dev, libfmt-dev, libpng-dev, libjpeg62-turbo-dev, libwebp-dev, libzstd-dev, libopenexr-dev, libdraco-dev, libmeshoptimizer-dev")
include(CPack)
