#include "raytrace/scene.h"

#include <cmath>
#include <cstring>

#include <tiny_gltf.h>
#include <Eigen/Geometry>

#include "oscillation/fall_speed.h"
#include "tests/scene_files.h"

namespace pluvia {
namespace {

const std::string camera =
    "[camera]\nposition_m = [1, 2, 3]\ntarget_m = [1, 5, 3]\nwidth_px = 320\nheight_px = 200\n"
    "vertical_fov_deg = 90\nexposure_s = 0.01\nwhite_cd_m2 = 7\n";

// A triangle (0,0,0) (1,0,0) (0,1,0) of glTF's axes, to be spoilt by each test.
struct Triangle {
  std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::vector<float> normals = {};
  std::vector<std::uint8_t> indices = {0, 1, 2};
  tinygltf::Model model = {};
};

template <typename T>
int add_accessor(tinygltf::Model& model, const std::vector<T>& values, int component, int type) {
  const std::size_t bytes = values.size() * sizeof(T);
  auto& data = model.buffers[0].data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = bytes;
  data.resize(data.size() + (bytes + 3) / 4 * 4);
  std::memcpy(data.data() + view.byteOffset, values.data(), bytes);
  model.bufferViews.push_back(view);
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model.bufferViews.size()) - 1;
  accessor.componentType = component;
  accessor.type = type;
  accessor.count = values.size() / (type == TINYGLTF_TYPE_VEC3 ? 3 : 1);
  model.accessors.push_back(accessor);
  return static_cast<int>(model.accessors.size()) - 1;
}

void build(Triangle& triangle) {
  tinygltf::Model& model = triangle.model;
  model.asset.version = "2.0";
  model.buffers.emplace_back();
  tinygltf::Primitive primitive;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.attributes["POSITION"] =
      add_accessor(model, triangle.positions, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  primitive.indices = add_accessor(model, triangle.indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE,
                                   TINYGLTF_TYPE_SCALAR);
  if (!triangle.normals.empty())
    primitive.attributes["NORMAL"] =
        add_accessor(model, triangle.normals, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3);
  model.meshes.emplace_back();
  model.meshes[0].primitives.push_back(primitive);
  model.nodes.emplace_back();
  model.nodes[0].mesh = 0;
  model.scenes.emplace_back();
  model.scenes[0].nodes = {0};
  model.defaultScene = 0;
}

std::string write_model(const tinygltf::Model& model, const std::string& name = "mesh.gltf") {
  const std::string file = scratch_file(name, "");
  const bool binary = name.find(".glb") != std::string::npos;
  tinygltf::TinyGLTF().WriteGltfSceneToFile(&model, file, true, true, true, binary);
  return file;
}

Scene read_with_mesh(const std::string& gltf) {
  return read_scene(scratch_file("scene.toml", camera + "[geometry]\nfile = \"" + gltf + "\"\n"));
}

std::string refusal_of_model(const tinygltf::Model& model) {
  const std::string file = write_model(model);
  const std::string message = message_of([&] { read_with_mesh(file); });
  EXPECT_EQ(message.find(file + ": "), 0u) << message;
  EXPECT_NE(message.find("; expected "), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

std::string refusal_of(const std::string& text) {
  const std::string file = scratch_file("street.toml", text);
  const std::string message = message_of([&] { read_scene(file); });
  return message.substr(std::min(message.size(), file.size() + 1));
}

TEST(Scene, EveryKeyArrivesWhereItBelongs) {
  const std::string file = scratch_file(
      "street.toml",
      camera +
          "[[light]]\nname = \"lamp\"\nposition_m = [0, 1, 5]\nintensity_cd = [3, 2, 1]\n"
          "[[light]]\nposition_m = [0, 2, 5]\nintensity_cd = [30, 20, 10]\n"
          "[environment]\nmap = \"sky/../night.exr\"\nscale_cd_m2 = 0.5\n"
          "[rain]\ndrops_per_m3 = 2\nmean_radius_m = 1e-3\nfall_speed_m_s = 6\n"
          "box_min_m = [-1, -2, -3]\nbox_max_m = [1, 2, 3]\nseed = 77\n");
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.camera.position_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.camera.target_m, Eigen::Vector3d(1, 5, 3));
  EXPECT_EQ(scene.camera.width_px, 320);
  EXPECT_EQ(scene.camera.height_px, 200);
  EXPECT_EQ(scene.camera.vertical_fov_deg, 90);
  EXPECT_EQ(scene.camera.exposure_s, 0.01);
  EXPECT_EQ(scene.camera.white_cd_m2, 7);
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].name, "lamp");
  EXPECT_EQ(scene.lights[1].position_m, Eigen::Vector3d(0, 2, 5));
  EXPECT_EQ(scene.lights[1].intensity_cd, Eigen::Vector3d(30, 20, 10));
  EXPECT_EQ(scene.environment.map_file,
            (std::filesystem::path(file).parent_path() / "night.exr").string());
  EXPECT_EQ(scene.environment.scale_cd_m2, 0.5);
  ASSERT_EQ(scene.rain.sizes.size(), 1u);
  EXPECT_EQ(scene.rain.sizes[0].drops_per_m3, 2);
  EXPECT_EQ(scene.rain.sizes[0].r0_m, 1e-3);
  EXPECT_EQ(scene.rain.sizes[0].velocity_m_s, Eigen::Vector3d(0, 0, -6));
  EXPECT_EQ(scene.rain.box_min_m, Eigen::Vector3d(-1, -2, -3));
  EXPECT_EQ(scene.rain.box_max_m, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.rain.seed, 77u);
  EXPECT_TRUE(scene.mesh.indices.empty());
}

TEST(Scene, AnythingOutOfRangeIsRefusedWithItsPlace) {
  EXPECT_EQ(refusal_of("[rain]\ndrops_per_m3 = 1\n"),
            "1:1: camera is missing; expected a table [camera]");
  EXPECT_EQ(refusal_of("[camera]\nposition_m = [0, 0, 0]\ntarget_m = [0, 0, 0]\n"),
            "3:1: camera.target_m is camera.position_m; expected another point");
  EXPECT_EQ(refusal_of("[camera]\nposition_m = [0, 0, 0]\ntarget_m = [0, 1, 0]\n"
                       "vertical_fov_deg = 151\n"),
            "4:1: camera.vertical_fov_deg = 151; expected 1 <= vertical_fov_deg <= 150 deg");
  EXPECT_EQ(refusal_of(camera + "[[light]]\nposition_m = [0, 0, 0]\nintensity_cd = [1, -1, 1]\n"),
            "11:1: light[0].intensity_cd[1] = -1; expected 0 <= intensity_cd[1] <= 1000000000");
  EXPECT_EQ(refusal_of(camera + "[environment]\nmap = \"a.exr\"\nuniform_cd_m2 = [1, 1, 1]\n"),
            "11:1: environment has map and uniform_cd_m2; expected one of them");
  EXPECT_EQ(refusal_of(camera + "[environment]\nscale_cd_m2 = 2\n"),
            "10:1: environment.scale_cd_m2 without a map; expected map beside it");
  EXPECT_EQ(refusal_of(camera + "[environment]\nframes_per_s = 24\n"),
            "10:1: environment.frames_per_s without a map; expected a clip of maps");
  EXPECT_EQ(refusal_of(camera + "[environment]\nmap = \"a.exr\"\nstart_s = 1\n"),
            "11:1: environment.start_s without frames_per_s; expected a clip of maps");
  EXPECT_EQ(refusal_of(camera + "[rain]\ndrops_per_m3 = 1\nbox_min_m = [-10, -10, 0]\n"
                                "box_max_m = [10, -10, 12]\n"),
            "12:1: rain.box_max_m[1] = -10; expected 0.001 m or more above box_min_m[1] = -10");
  EXPECT_EQ(refusal_of(camera + "[rain]\ndrops_per_m3 = 1\nrate_mm_h = 4\n"),
            "9:1: rain has 2 of drops_per_m3, drops_per_m2_s and rate_mm_h; expected one of them");
  EXPECT_EQ(refusal_of(camera + "[rain]\nrate_mm_h = 301\n"),
            "10:1: rain.rate_mm_h = 301; expected 0 <= rate_mm_h <= 300 mm/h");
  EXPECT_EQ(refusal_of(camera + "[rain]\nrate_mm_h = 0.001\n"),
            "10:1: rain.rate_mm_h = 0.001; expected 0 or 0.01 .. 300 mm/h");
  EXPECT_EQ(refusal_of(camera + "[rain]\nrate_mm_h = 4\ndistribution = \"mp\"\n"),
            "11:1: rain.distribution = \"mp\"; expected \"marshall-palmer\" or \"willis\"");
  EXPECT_EQ(refusal_of(camera + "[rain]\nrate_mm_h = 4\nmean_radius_m = 1e-3\n")
                .find("11:1: unknown key \"mean_radius_m\" in [rain]; "),
            0u);
  EXPECT_EQ(refusal_of(camera + "[rain]\nrate_mm_h = 4\nfall_direction = [1, 0, 0]\n"),
            "11:1: rain.fall_direction[2] = 0; expected less than 0");
  EXPECT_EQ(
      refusal_of(camera + "[wind]\nvelocity_m_s = [0, 0, 9]\n[rain]\ndrops_per_m3 = 1\n"),
      "11:1: rain: drops of 3.2 mm move at (0, 0, 0.7449) m/s; expected a fall of 0.01 m/s or "
      "more, at most 200 m/s in all");
  EXPECT_EQ(refusal_of(camera + "[rain]\ndrops_per_m3 = 4\ndensity_map = \"a.png\"\n"),
            "11:1: rain.density_map without a box; expected box_min_m and box_max_m");
  EXPECT_EQ(refusal_of(camera + "[wind]\n"),
            "9:1: wind.velocity_m_s is missing; expected an array of 3 numbers");
  EXPECT_EQ(refusal_of(camera + "[[drop]]\ncentre_m = [0, 0, 0]\nvelocity_m_s = [0, 0, 0]\n"),
            "11:1: drop.velocity_m_s has length 0; expected 0.01 m/s or more");
  EXPECT_EQ(refusal_of("[camera]\nposition_m = [0, 0, 0]\ntarget_m = [0, 1, 0]\nexposure_s = 0\n"),
            "4:1: camera.exposure_s = 0; expected 0 < exposure_s <= 1 s");
  EXPECT_EQ(refusal_of(camera + "[rian]\n"), "9:2: unknown key \"rian\"; did you mean \"rain\"?");
  EXPECT_EQ(refusal_of(camera + "fps = 3\n").find("9:1: unknown key \"fps\" in [camera]; "), 0u);
}

std::string path_camera(const std::string& keys) {
  return "[camera]\nwidth_px = 32\n" + keys;
}

std::string key_at(double time_s, const std::string& position, const std::string& target) {
  return fmt::format("[[camera.key]]\ntime_s = {}\nposition_m = {}\ntarget_m = {}\n", time_s,
                     position, target);
}

TEST(Scene, ACameraPathPassesItsKeysSmoothlyAndRestsAtItsEnds) {
  const Scene scene =
      read_scene(scratch_file("s.toml", path_camera(key_at(1, "[0, 0, 1]", "[0, 5, 1]") +
                                                    key_at(2, "[4, 0, 1]", "[0, 5, 1]") +
                                                    key_at(5, "[4, 6, 2]", "[0, 9, 1]"))));
  ASSERT_EQ(scene.camera_path.size(), 3u);
  EXPECT_EQ(scene.camera.position_m, Eigen::Vector3d(0, 0, 1));
  for (const CameraKey& key : scene.camera_path) {
    EXPECT_LT((camera_at(scene, key.time_s).position_m - key.position_m).norm(), 1e-12);
    EXPECT_LT((camera_at(scene, key.time_s).target_m - key.target_m).norm(), 1e-12);
  }
  EXPECT_EQ(camera_at(scene, 0).position_m, scene.camera_path.front().position_m);
  EXPECT_EQ(camera_at(scene, 99).target_m, scene.camera_path.back().target_m);
  EXPECT_EQ(camera_at(scene, 3).width_px, 32);
  const auto velocity = [&](double t) -> Eigen::Vector3d {
    return (camera_at(scene, t + 1e-6).position_m - camera_at(scene, t - 1e-6).position_m) / 2e-6;
  };
  EXPECT_LT((velocity(2 - 1e-5) - velocity(2 + 1e-5)).norm(), 1e-3);
  EXPECT_LT((velocity(2) - Eigen::Vector3d(1, 1.5, 0.25)).norm(), 1e-4);
  EXPECT_LT(velocity(1 + 1e-5).norm(), 1e-3);
  EXPECT_EQ(camera_samples(scene, 5).size(), 5u);
  EXPECT_EQ(camera_samples(Scene{}, 5).size(), 1u);
}

TEST(Scene, DepthOfFieldIsReadByApertureOrByFNumber) {
  EXPECT_FALSE(read_scene(scratch_file("s.toml", camera)).camera.depth_of_field);
  const auto lens_of = [](const std::string& keys) {
    const std::string text = camera + "[depth_of_field]\n" + keys;
    return read_scene(scratch_file("s.toml", text)).camera.depth_of_field.value();
  };
  EXPECT_EQ(lens_of("aperture_m = 0.03\nfocus_m = 4\n").aperture_m, 0.03);
  EXPECT_EQ(lens_of("aperture_m = 0.03\nfocus_m = 4\n").focus_m, 4);
  EXPECT_TRUE(std::isinf(lens_of("aperture_m = 0\n").focus_m));
  // 24 mm at 90 degrees: a focal length of 12 mm.
  EXPECT_NEAR(lens_of("f_number = 2\n").aperture_m, 6e-3, 1e-12);
}

TEST(Scene, TheFocusTurnsFromKeyToKey) {
  const std::string first = key_at(1, "[0, 0, 1]", "[0, 5, 1]") + "focus_m = 2\n";
  const std::string second = key_at(3, "[0, 1, 1]", "[0, 5, 1]") + "focus_m = 6\n";
  const std::string third = key_at(4, "[0, 2, 1]", "[0, 5, 1]");
  const std::string lens = "[depth_of_field]\naperture_m = 0.02\n";
  const Scene scene =
      read_scene(scratch_file("s.toml", path_camera(first + second + third + lens)));
  const auto focus_m = [&](double t) { return camera_at(scene, t).depth_of_field->focus_m; };
  EXPECT_EQ(focus_m(0), 2);
  EXPECT_NEAR(focus_m(2), 3, 1e-12);    // 1/2 and 1/6 have the mean 1/3
  EXPECT_NEAR(focus_m(3.5), 12, 1e-9);  // half-way to infinity
  EXPECT_TRUE(std::isinf(focus_m(9)));
  EXPECT_EQ(scene.camera.depth_of_field->focus_m, 2);
  EXPECT_EQ(refusal_of(path_camera(first + second)),
            "7:1: camera.key[0].focus_m without an aperture; expected a table [depth_of_field]");
}

TEST(Scene, MistakesInTheDepthOfFieldAreRefused) {
  const auto refusal = [](const std::string& keys) {
    return refusal_of(camera + "[depth_of_field]\n" + keys);
  };
  EXPECT_EQ(refusal("focus_m = 2\n"),
            "10:1: depth_of_field has neither of f_number and aperture_m; expected one of them");
  EXPECT_EQ(refusal("f_number = 2\naperture_m = 0.1\n"),
            "9:1: depth_of_field has both f_number and aperture_m; expected one of them");
  EXPECT_EQ(refusal("f_number = 0.1\n"),
            "10:1: depth_of_field.f_number = 0.1; expected 0.5 <= f_number <= 128");
  EXPECT_EQ(refusal("aperture_m = 2\n"),
            "10:1: depth_of_field.aperture_m = 2; expected 0 <= aperture_m <= 1 m");
  EXPECT_EQ(refusal("f_number = 2\nfocus_m = 0.01\n"),
            "11:1: depth_of_field.focus_m = 0.01; expected 0.1 <= focus_m <= 1000000 m");
  EXPECT_EQ(refusal("f_number = 2\nfocus = 3\n"),
            "11:1: unknown key \"focus\" in [depth_of_field]; did you mean \"focus_m\"?");
}

TEST(Scene, ACameraNeverStandsInItsTarget) {
  // Position and target cross half-way.
  Scene scene;
  scene.camera_path = {{0, {0, 0, 0}, {1, 0, 0}}, {1, {1, 0, 0}, {0, 0, 0}}};
  for (int i = 0; i <= 1000; ++i) {
    const Camera now = camera_at(scene, i / 1000.0);
    ASSERT_GE((now.target_m - now.position_m).norm(), 0.999e-3) << i;
    ASSERT_TRUE(camera_frame(now).forward.allFinite());
  }
}

TEST(Scene, MistakesInACameraPathAreRefused) {
  const auto refusal = [](const std::string& text) { return refusal_of(path_camera(text)); };
  const std::string first = key_at(1, "[0, 0, 1]", "[0, 5, 1]");
  EXPECT_EQ(refusal(first),
            "3:10: camera has 1 key; expected 2 or more, or position_m and target_m");
  EXPECT_EQ(refusal(first + key_at(1, "[0, 0, 1]", "[0, 5, 1]")),
            "8:1: camera.key[1].time_s = 1; expected 0.001 s or more after the one before");
  EXPECT_EQ(refusal(first + key_at(2, "[0, 0, 1]", "[0, 0, 1]")),
            "10:1: camera.key[1].target_m is camera.key[1].position_m; expected another point");
  EXPECT_NE(refusal("position_m = [0, 0, 0]\n" + first + key_at(2, "[0, 0, 1]", "[0, 3, 1]"))
                .find("unknown key \"position_m\""),
            std::string::npos);
}

TEST(Scene, EveryKindOfLightIsReadAndItsMistakesAreRefused) {
  const Scene scene = read_scene(
      scratch_file("s.toml", camera + "[[light]]\nkind = \"spot\"\nposition_m = [1, 2, 3]\n"
                                      "intensity_cd = [4, 5, 6]\ndirection = [0, 0, -2]\n"
                                      "outer_half_angle_deg = 30\nradius_m = 0.1\nshadow = true\n"
                                      "[[light]]\nkind = \"sun\"\ndirection = [3, 0, -4]\n"
                                      "illuminance_lux = [9, 8, 7]\n"));
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].kind, LightKind::spot);
  EXPECT_EQ(scene.lights[0].direction, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(scene.lights[0].inner_half_angle_deg, 24);
  EXPECT_EQ(scene.lights[0].radius_m, 0.1);
  EXPECT_TRUE(scene.lights[0].shadow);
  EXPECT_LT((scene.lights[1].direction - Eigen::Vector3d(0.6, 0, -0.8)).norm(), 1e-12);
  EXPECT_EQ(scene.lights[1].illuminance_lux, Eigen::Vector3d(9, 8, 7));
  EXPECT_EQ(refusal_of(camera + "[[light]]\nkind = \"area\"\n"),
            "10:1: light.kind = \"area\"; expected \"point\", \"spot\" or \"sun\"");
  EXPECT_EQ(refusal_of(camera + "[[light]]\nkind = \"sun\"\nilluminance_lux = [1, 1, 1]\n"
                                "direction = [0, 0, 0]\n"),
            "12:1: light.direction is zero; expected the way the light goes");
  EXPECT_NE(refusal_of(camera + "[[light]]\nkind = \"sun\"\nilluminance_lux = [1, 1, 1]\n"
                                "direction = [0, 0, -1]\nposition_m = [0, 0, 0]\n")
                .find("13:1: unknown key \"position_m\""),
            std::string::npos);
  EXPECT_NE(refusal_of(camera + "[[light]]\nkind = \"spot\"\nposition_m = [0, 0, 0]\n"
                                "intensity_cd = [1, 1, 1]\ndirection = [0, 0, -1]\n"
                                "inner_half_angle_deg = 60\n")
                .find("14:1: light[0].inner_half_angle_deg = 60; expected 0 <="),
            std::string::npos);
}

TEST(Scene, ARateBecomesSizesThatFallByThemselvesAndDriftWithTheWind) {
  const Scene scene = read_scene(
      scratch_file("s.toml", camera + "[rain]\nrate_mm_h = 12\nsizes = 3\nleast_diameter_mm = 1\n"
                                      "[wind]\nvelocity_m_s = [3, -1, 0]\n"));
  ASSERT_EQ(scene.rain.sizes.size(), 3u);
  for (const RainSize& size : scene.rain.sizes)
    EXPECT_LT((size.velocity_m_s - Eigen::Vector3d(3, -1, -fall_speed_m_s(2 * size.r0_m))).norm(),
              1e-12);
  EXPECT_GT(scene.rain.sizes[0].r0_m, 0.5e-3);
  const Scene flux = read_scene(
      scratch_file("s.toml", camera + "[rain]\ndrops_per_m2_s = 40\nfall_speed_m_s = 10\n"
                                      "fall_direction = [3, 0, -4]\n"));
  EXPECT_LT((flux.rain.sizes[0].velocity_m_s - Eigen::Vector3d(6, 0, -8)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(flux.rain.sizes[0].drops_per_m3, 5);
  for (const char* dry : {"rate_mm_h = 0", "drops_per_m3 = 0", "drops_per_m2_s = 0"})
    EXPECT_TRUE(
        read_scene(scratch_file("s.toml", camera + "[rain]\n" + dry + "\n")).rain.sizes.empty());
}

TEST(Scene, SplashesNeedRain) {
  const std::string rain = "[rain]\ndrops_per_m3 = 1\n", drop = "[[drop]]\ncentre_m = [0, 0, 1]\n";
  const auto read = [](const std::string& tables) {
    return read_scene(scratch_file("scene.toml", camera + tables));
  };
  EXPECT_FALSE(read(rain).splashes.has_value());
  EXPECT_TRUE(read(rain + "[splashes]\n").splashes.has_value());
  EXPECT_TRUE(read(drop + "[splashes]\n").splashes.has_value());
  EXPECT_NE(
      message_of([&] { read("[splashes]\n"); }).find("splashes without rain; expected a table"),
      std::string::npos);
  EXPECT_NE(message_of([&] { read(rain + "[splashes]\nheight_m = 1\n"); }).find("height_m"),
            std::string::npos);
}

TEST(Scene, DarkeningAndBlurAreReadAndTheirMistakesRefused) {
  const auto read_text = [](const std::string& tables) {
    return read_scene(scratch_file("scene.toml", camera + tables));
  };
  const Scene bare = read_text("");
  EXPECT_FALSE(bare.darkening.has_value() || bare.blur.has_value());
  const Scene scene = read_text("[darkening]\ndesaturation = 0.4\n[blur]\nsigma_px = 2.5\n");
  EXPECT_EQ(scene.darkening->desaturation, 0.4);
  EXPECT_EQ(scene.darkening->brightness, 1);
  EXPECT_EQ(scene.blur->sigma_px, 2.5);
  for (const char* wrong : {"[darkening]\ndesaturation = 1.1\n", "[darkening]\nbrightness = 0\n",
                            "[darkening]\nsigma_px = 1\n", "[blur]\n", "[blur]\nsigma_px = 0\n"})
    EXPECT_THROW(read_text(wrong), std::runtime_error) << wrong;
}

TEST(Scene, ACamerasAxesAreRightHandedInEveryDirection) {
  for (const Eigen::Vector3d& target :
       {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(3, -2, 1), Eigen::Vector3d(0, 0, 1),
        Eigen::Vector3d(0, 0, -5), Eigen::Vector3d(1e-7, 0, -1), Eigen::Vector3d(1e-5, 0, 1)}) {
    const CameraFrame frame = camera_frame(
        {.position_m = {0, 0, 0}, .target_m = target, .vertical_fov_deg = 90, .height_px = 200});
    EXPECT_NEAR(frame.right.norm(), 1, 1e-12);
    EXPECT_NEAR(frame.up.norm(), 1, 1e-12);
    EXPECT_LT((frame.right.cross(frame.up) + frame.forward).norm(), 1e-12);
    EXPECT_LT((frame.forward - target.normalized()).norm(), 1e-12);
    EXPECT_NEAR(frame.right.z(), 0, 1e-6);  // the horizon is level
    EXPECT_GE(frame.up.z(), 0);
    EXPECT_NEAR(frame.focal_px, 100, 1e-9);  // tan 45 = 1
  }
}

TEST(Scene, AVerticalViewHasEastAtTheRight) {
  for (double z : {1.0, -1.0}) {
    const CameraFrame frame = camera_frame({.position_m = {0, 0, 0}, .target_m = {0, 0, z}});
    EXPECT_LT((frame.right - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
    EXPECT_LT((frame.up - Eigen::Vector3d(0, -z, 0)).norm(), 1e-12);
  }
}

TEST(Scene, GltfIsTurnedFromYUpToZUp) {
  // (X, Y, Z) -> (X, -Z, Y), applied after the node's own transform; the flat normal of the
  // triangle is +Z there, that is -y here.
  Triangle triangle;
  build(triangle);
  triangle.model.nodes[0].translation = {10, 20, 30};
  triangle.model.nodes[0].scale = {2, 3, 4};
  for (const char* name : {"mesh.gltf", "mesh.glb"}) {
    const Mesh mesh = read_with_mesh(write_model(triangle.model, name)).mesh;
    ASSERT_EQ(mesh.indices.size(), 3u);
    EXPECT_EQ(mesh.positions_m[0], Eigen::Vector3f(10, -30, 20));
    EXPECT_EQ(mesh.positions_m[1], Eigen::Vector3f(12, -30, 20));
    EXPECT_EQ(mesh.positions_m[2], Eigen::Vector3f(10, -30, 23));
    for (const auto& normal : mesh.normals)
      EXPECT_LT((normal - Eigen::Vector3f(0, -1, 0)).norm(), 1e-6f);
  }
}

TEST(Scene, AMirroredChildKeepsItsOutsideOutside) {
  // Parent: a quarter turn about Y takes X to -Z. Child: mirrored in X. The winding is turned over,
  // so the face normal keeps agreeing with the given one, carried by the inverse transpose.
  Triangle triangle;
  triangle.normals = {0, 0, 1, 0, 0, 1, 0, 0, 1};
  build(triangle);
  tinygltf::Node parent;
  parent.rotation = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};
  parent.children = {0};
  triangle.model.nodes[0].scale = {-1, 1, 1};
  triangle.model.nodes.push_back(parent);
  triangle.model.scenes[0].nodes = {1};
  const Mesh mesh = read_with_mesh(write_model(triangle.model)).mesh;
  const auto corner = [&](std::size_t i) { return mesh.positions_m[mesh.indices[i]]; };
  const Eigen::Vector3f face = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
  EXPECT_LT((face - mesh.normals[0]).norm(), 1e-6f);
  // +Z turns to +X.
  EXPECT_LT((face - Eigen::Vector3f(1, 0, 0)).norm(), 1e-6f);
}

TEST(Scene, AStretchedSurfaceKeepsItsNormalsPerpendicular) {
  // The triangle (0,0,0) (1,0,0) (0,1,1) has normal (0,-1,1)/sqrt 2; stretched 4 times along Y the
  // surface steepens and its normal is (0,-1,4)/sqrt 17, that is (0,-4,-1)/sqrt 17 in the world.
  Triangle triangle;
  triangle.positions = {0, 0, 0, 1, 0, 0, 0, 1, 1};
  const float h = std::sqrt(0.5f);
  triangle.normals = {0, -h, h, 0, -h, h, 0, -h, h};
  build(triangle);
  triangle.model.nodes[0].scale = {1, 4, 1};
  const Mesh mesh = read_with_mesh(write_model(triangle.model)).mesh;
  const Eigen::Vector3f expected = Eigen::Vector3f(0, -4, -1) / std::sqrt(17.0f);
  EXPECT_LT((mesh.normals[0] - expected).norm(), 1e-6f);
}

TEST(Scene, AMaterialsEmissionIsFactorTimesStrength) {
  Triangle triangle;
  build(triangle);
  tinygltf::Material material;
  material.pbrMetallicRoughness.baseColorFactor = {0.1, 0.2, 0.3, 1};
  material.emissiveFactor = {1, 0.5, 0.25};
  material.extensions["KHR_materials_emissive_strength"] =
      tinygltf::Value(tinygltf::Value::Object{{"emissiveStrength", tinygltf::Value(40.0)}});
  triangle.model.materials.push_back(material);
  triangle.model.meshes[0].primitives[0].material = 0;
  const Mesh mesh = read_with_mesh(write_model(triangle.model)).mesh;
  const Material& read = mesh.materials[mesh.triangle_material[0]];
  EXPECT_LT((read.base_color - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((read.emission_cd_m2 - Eigen::Vector3d(40, 20, 10)).norm(), 1e-12);
  triangle.model.materials[0].pbrMetallicRoughness.baseColorFactor[1] = 1.5;
  EXPECT_NE(refusal_of_model(triangle.model).find("baseColorFactor 1.5"), std::string::npos);
}

TEST(Scene, IndicesOfEveryWidthMeanTheSame) {
  for (int component :
       {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT,
        TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT}) {
    Triangle triangle;
    build(triangle);
    auto& indices = triangle.model.meshes[0].primitives[0].indices;
    if (component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT)
      indices =
          add_accessor<std::uint16_t>(triangle.model, {2, 1, 0}, component, TINYGLTF_TYPE_SCALAR);
    else if (component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
      indices =
          add_accessor<std::uint32_t>(triangle.model, {2, 1, 0}, component, TINYGLTF_TYPE_SCALAR);
    else
      indices =
          add_accessor<std::uint8_t>(triangle.model, {2, 1, 0}, component, TINYGLTF_TYPE_SCALAR);
    const Mesh mesh = read_with_mesh(write_model(triangle.model)).mesh;
    EXPECT_EQ(mesh.positions_m[mesh.indices[0]], Eigen::Vector3f(0, 0, 1)) << component;
    EXPECT_EQ(mesh.positions_m[mesh.indices[2]], Eigen::Vector3f(0, 0, 0)) << component;
  }
}

TEST(Scene, SpoiltGeometryIsRefusedAndNeverReadBeyondItsEnd) {
  const auto spoilt = [](const std::function<void(Triangle&)>& before,
                         const std::function<void(tinygltf::Model&)>& after) {
    Triangle triangle;
    before(triangle);
    build(triangle);
    after(triangle.model);
    return refusal_of_model(triangle.model);
  };
  const auto as_is = [](auto&) {};
  const auto says = [](const std::string& message, const char* what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  says(spoilt([](auto& t) { t.positions[4] = std::nanf(""); }, as_is), "POSITION 1");
  says(spoilt([](auto& t) { t.positions[8] = HUGE_VALF; }, as_is), "POSITION 2");
  says(spoilt([](auto& t) { t.normals = std::vector<float>(9, 0); }, as_is), "length 0");
  says(spoilt([](auto& t) { t.normals = {0, 0, 1}; }, as_is), "1 normals");
  says(spoilt([](auto& t) { t.indices[2] = 3; }, as_is), "index 3");
  says(spoilt([](auto& t) { t.indices.push_back(0); }, as_is), "4 indices");
  says(spoilt(as_is, [](auto& m) { m.accessors[0].count = 4; }), "4 elements");
  says(spoilt(as_is, [](auto& m) { m.accessors[0].byteOffset = 4; }), "from byte 4");
  says(spoilt(as_is, [](auto& m) { m.bufferViews[0].byteLength = 1000; }), "");
  says(spoilt(as_is, [](auto& m) { m.accessors[1].bufferView = 9; }), "bufferView");
  says(spoilt(as_is, [](auto& m) { m.accessors[0].type = TINYGLTF_TYPE_VEC2; }), "VEC3");
  says(spoilt(as_is, [](auto& m) { m.meshes[0].primitives[0].mode = TINYGLTF_MODE_LINE; }),
       "mode 1");
  says(spoilt(as_is, [](auto& m) { m.meshes[0].primitives[0].material = 5; }), "material 5");
  says(spoilt(as_is, [](auto& m) { m.nodes[0].mesh = 2; }), "mesh 2");
  says(spoilt(as_is, [](auto& m) { m.nodes[0].scale = {1, 0, 1}; }), "determinant 0");
  says(spoilt(as_is, [](auto& m) { m.nodes[0].children = {0}; }), "reached twice");
  says(spoilt(as_is, [](auto& m) { m.extensionsRequired = {"KHR_draco_mesh_compression"}; }),
       "KHR_draco_mesh_compression");
}

TEST(Scene, AGltfThatIsMissingOrNoGltfIsToldInOneLine) {
  const std::string missing = message_of([] { read_with_mesh("/nowhere/a.gltf"); });
  EXPECT_EQ(missing, "/nowhere/a.gltf: no such file; expected a glTF 2.0 file");
  for (const char* text : {"", "{", "{}", "[1, 2]", "{\"asset\": {\"version\": \"1.0\"}}",
                           "{\"asset\": {\"version\": \"2.0\"}}", "glTF\x02", "\xff\xfe\x00"})
    for (const char* name : {"a.gltf", "a.glb"}) {
      const std::string file = scratch_file(name, text);
      const std::string message = message_of([&] { read_with_mesh(file); });
      EXPECT_EQ(message.find(file + ": "), 0u) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      EXPECT_NE(message.find("; expected "), std::string::npos) << message;
    }
}

}  // namespace
}  // namespace pluvia
