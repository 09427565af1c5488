// A world of triangles and voxels.
#pragma once

#include <gtest/gtest.h>

#include "world/voxel_worlds.h"

namespace sinew::test {

// Two balls of triangles, two rigid octrees of one shape, and three of a moving one, of which two
// are in the same pose.
struct Mixed {
  Shape ball = sphere(3);
  Svo rigid = plain_octree(40, 900, 1, 5);
  Svo moving = moving_octree(70, 1200, 6);
  std::vector<OwnPose> poses = {moving_pose(1), moving_pose(1), moving_pose(2)};
  World world, triangles_alone;
  std::vector<Affine> places;
  ObjectId rigids[2], movings[3];

  explicit Mixed(uint32_t seed, TopTree top = TopTree::objects) {
    Random random(seed);
    world.set_top_tree(top);
    for (World* w : {&world, &triangles_alone}) {
      const BodyId body = *w->add_body({ball.triangles, RigidMotion{ball.positions}, Pose(), {}});
      for (int i = 0; i < 2; ++i) {
        if (places.size() < 2) places.push_back(random_place(random, 5.0f));
        EXPECT_TRUE(w->set_pose(*w->add_object(body), placed(places[i])));
      }
      w->commit();
    }
    const BodyId still = *world.add_octree({&rigid}), moves = *world.add_octree({&moving});
    for (ObjectId& id : rigids) {
      id = *world.add_object(still);
      places.push_back(random_place(random, 5.0f));
      EXPECT_TRUE(world.set_pose(id, placed(places.back())));
    }
    for (size_t i = 0; i < 3; ++i) {
      movings[i] = *world.add_object(moves);
      poses[i].placement = i == 2 ? identity_affine() : random_place(random, 5.0f);
      places.push_back(poses[i].placement);
      EXPECT_TRUE(world.set_pose(movings[i], poses[i].pose()));
    }
    world.commit();
  }
};

}  // namespace sinew::test
