#include "raytrace/top_height.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include "tests/scene_files.h"

namespace pluvia {
namespace {

void add_triangle(Mesh& mesh, const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                  const Eigen::Vector3f& c) {
  for (const auto& p : {a, b, c}) {
    mesh.indices.push_back(static_cast<std::uint32_t>(mesh.positions_m.size()));
    mesh.positions_m.push_back(p);
  }
}

double centre(double low, int i, double texel_m) {
  return low + (i + 0.5) * texel_m;
}

TEST(TopHeight, ASlopeIsExactEverywhere) {
  // z = 0.5 x - 0.25 y + 2 over the whole box; float rounding of the height is 1e-7 of it.
  const auto at = [](float x, float y) { return Eigen::Vector3f(x, y, 0.5f * x - 0.25f * y + 2); };
  Mesh mesh;
  add_triangle(mesh, at(-20, -20), at(20, -20), at(0, 40));
  const TopHeight top = top_height(mesh, FallFrame{}, {-3, -2, 3, 2}, 0.1);
  EXPECT_EQ(top.width, 60);
  EXPECT_EQ(top.height, 40);
  for (int j = 0; j < top.height; ++j)
    for (int i = 0; i < top.width; ++i) {
      const double x = centre(-3, i, 0.1) + 0.04, y = centre(-2, j, 0.1) - 0.03;
      ASSERT_NEAR(height_at(top, x, y), 0.5 * x - 0.25 * y + 2, 1e-6) << x << ", " << y;
    }
}

TEST(TopHeight, TheHighestOfStackedSurfacesWinsInAnyOrder) {
  for (bool roof_first : {true, false}) {
    Mesh mesh;
    for (int i = 0; i < 2; ++i) {
      const float z = (i == 0) == roof_first ? 4.0f : 1.0f;
      add_triangle(mesh, {-9, -9, z}, {9, -9, z}, {0, 30, z});
    }
    const TopHeight top = top_height(mesh, FallFrame{}, {-1, -1, 1, 1}, 0.5);
    for (const TopTexel& texel : top.texels) EXPECT_EQ(texel.z_m, 4.0f) << roof_first;
  }
}

TEST(TopHeight, NeighboursLeaveNoGapAlongAnyEdge) {
  // Fans of triangles round a point fill the box; their common edges run through texel centres when
  // the hub is on one.
  std::mt19937 random(7);
  std::uniform_real_distribution<float> inside(-0.9f, 0.9f);
  for (int trial = 0; trial < 200; ++trial) {
    Eigen::Vector3f hub(inside(random), inside(random), 1);
    if (trial % 2 == 0) hub = {0.125f * static_cast<float>(trial % 8) + 0.0625f, 0.0625f, 1};
    Mesh mesh;
    const int spokes = 3 + trial % 13;
    for (int i = 0; i < spokes; ++i) {
      const auto rim = [&](int k) -> Eigen::Vector3f {
        const float angle =
            6.2831853f * static_cast<float>(k % spokes) / static_cast<float>(spokes);
        return {hub.x() + 30 * std::cos(angle), hub.y() + 30 * std::sin(angle), 1};
      };
      add_triangle(mesh, hub, rim(i), rim(i + 1));
    }
    const TopHeight top = top_height(mesh, FallFrame{}, {-1, -1, 1, 1}, 0.125);
    for (const TopTexel& texel : top.texels)
      ASSERT_NEAR(texel.z_m, 1.0f, 1e-6f) << "trial " << trial;
  }
}

TEST(TopHeight, AThinWallAndAFlatTriangleHaveNoTop) {
  Mesh mesh;
  add_triangle(mesh, {0, -5, 0}, {0, 5, 0}, {0, 0, 9});       // vertical
  add_triangle(mesh, {-5, 0, 3}, {0, 0, 3}, {5, 0, 3});       // no area
  add_triangle(mesh, {50, 50, 3}, {60, 50, 3}, {50, 60, 3});  // outside the box
  const TopHeight top = top_height(mesh, FallFrame{}, {-1, -1, 1, 1}, 0.1);
  for (const TopTexel& texel : top.texels) EXPECT_EQ(texel.z_m, -1e30f);
}

TEST(TopHeight, ATriangleSmallerThanATexelCoversItAndNoOther) {
  Mesh mesh;
  add_triangle(mesh, {0.70f, 0.70f, 5}, {0.72f, 0.70f, 5}, {0.70f, 0.72f, 5});
  const TopHeight top = top_height(mesh, FallFrame{}, {0, 0, 1, 1}, 0.5);
  EXPECT_EQ(height_at(top, 0.9, 0.6), 5);
  for (const auto& [x, y] : {std::pair(0.1, 0.4), {0.9, 0.4}, {0.4, 0.9}})
    EXPECT_LT(height_at(top, x, y), -1e29);
}

TEST(TopHeight, EveryPointUnderATriangleIsUnderItsTop) {
  std::mt19937 random(12);
  std::uniform_real_distribution<float> place(-1.5f, 1.5f), share(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    Mesh mesh;
    Eigen::Vector3f corner[3];
    for (auto& c : corner) c = {place(random), place(random), 3};
    add_triangle(mesh, corner[0], corner[1], corner[2]);
    const TopHeight top = top_height(mesh, FallFrame{}, {-2, -2, 2, 2}, 0.17);
    for (int i = 0; i < 200; ++i) {
      float u = share(random), v = share(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Eigen::Vector3f p =
          corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]);
      ASSERT_NEAR(height_at(top, static_cast<double>(p.x()), static_cast<double>(p.y())), 3, 1e-5);
    }
    // And the top reaches no farther than a texel's diagonal beyond it: its area is bounded.
    const Eigen::Vector2f ab = (corner[1] - corner[0]).head<2>(),
                          ac = (corner[2] - corner[0]).head<2>();
    const double area = 0.5 * std::abs(static_cast<double>(ab.x() * ac.y() - ab.y() * ac.x()));
    const double rim = static_cast<double>(ab.norm() + ac.norm() + (ac - ab).norm());
    double covered = 0;
    for (const TopTexel& texel : top.texels) covered += texel.z_m > 0 ? 0.17 * 0.17 : 0;
    ASSERT_LE(covered, area + rim * 0.17 * 1.42 + 8 * 0.17 * 0.17) << trial;
  }
}

TEST(TopHeight, NothingIsThereOutsideTheGridOrWithoutSurfaces) {
  const TopHeight top = top_height({}, FallFrame{}, {-1, -1, 1, 1}, 0.3);
  EXPECT_EQ(top.width, 7);  // ceil(2 / 0.3): the grid covers the box
  EXPECT_LT(height_at(top, 0, 0), -1e29);
  for (double x : {-1.001, 1.101, 1e300, std::nan("")}) EXPECT_LT(height_at(top, x, 0), -1e29);
}

TEST(TopHeight, BesideTheGridThereIsNoSurfaceEvenWhereTheMeshGoesOn) {
  Mesh mesh;
  add_triangle(mesh, {-9, -9, 3}, {9, -9, 3}, {0, 30, 3});
  const TopHeight top = top_height(mesh, FallFrame{}, {-1, -1, 1, 1}, 0.5);
  for (double off : {-1.01, -1.4, 1.01, 1.4}) {
    EXPECT_LT(height_at(top, off, 0), -1e29) << off;
    EXPECT_LT(height_at(top, 0, off), -1e29) << off;
  }
  EXPECT_EQ(height_at(top, -1, -1), 3);
}

TEST(TopHeight, AnAlmostUprightSurfaceIsNotCarriedBeyondItsCentre) {
  Mesh mesh;
  add_triangle(mesh, {0, -5, 0}, {0, 5, 0}, {0.2f, 0, 9});  // 45 in 1
  const TopHeight top = top_height(mesh, FallFrame{}, {-1, -1, 1, 1}, 0.1);
  for (double x = -1; x < 1; x += 0.013) EXPECT_LE(height_at(top, x, 0), 9);
}

TEST(TopHeight, AnEmptyRectangleHasNoTexels) {
  for (const PlaneRect& rect : {PlaneRect{1, 0, 1, 2}, PlaneRect{1e300, 1e300, -1e300, -1e300}})
    EXPECT_TRUE(top_height({}, FallFrame{}, rect, 0.1).texels.empty());
}

TEST(TopHeight, SeenAlongASlantedFallASlopeIsWhereItsPointsAreThrown) {
  // The height along the fall's axis over (x, y) of its frame, for z = 0.5 x - 0.25 y + 2 in the
  // world: solved for the point of that plane.
  const FallFrame frame = fall_frame({5, -2, -7});
  const auto at = [](float x, float y) { return Eigen::Vector3f(x, y, 0.5f * x - 0.25f * y + 2); };
  Mesh mesh;
  add_triangle(mesh, at(-40, -40), at(40, -40), at(0, 80));
  const TopHeight top = top_height(mesh, frame, {-3, -2, 3, 2}, 0.1);
  const Eigen::Vector3d normal(0.5, -0.25, -1);
  for (int j = 0; j < top.height; ++j)
    for (int i = 0; i < top.width; ++i) {
      const double x = centre(-3, i, 0.1), y = centre(-2, j, 0.1);
      const double z = (-2 - normal.dot(x * frame.x + y * frame.y)) / normal.dot(frame.z);
      ASSERT_NEAR(height_at(top, x, y), z, 3e-6) << x << ", " << y;
    }
  const auto lower = [](const TopTexel& a, const TopTexel& b) { return a.z_m < b.z_m; };
  EXPECT_EQ(top.lowest_m, std::min_element(top.texels.begin(), top.texels.end(), lower)->z_m);
}

TEST(TopHeight, AGridThatFillsTheMemoryIsRefused) {
  const std::string message = message_of([] {
    top_height({}, FallFrame{}, {-1000, -1000, 1000, 1000}, 0.01);
  });
  EXPECT_NE(message.find("200000 x 200000 texels"), std::string::npos) << message;
}

}  // namespace
}  // namespace pluvia
