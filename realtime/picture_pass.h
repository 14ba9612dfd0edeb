// A picture and its depth in place of the scene's surfaces (RenderOptions::over_picture): drops,
// splashes, fog and the composite see them as they see surfaces. What the scene has of surfaces
// is not drawn then, yet still shelters, is splashed upon and casts shadows.
#pragma once

#include "atlas/image.h"
#include "realtime/frame_plan.h"
#include "realtime/gl_objects.h"
#include "realtime/gpu_scene.h"
#include "realtime/scene_pass.h"

namespace pluvia {

struct Picture {       // both of the camera's size
  Image color = {};    // RGB, cd/m^2, finite, >= 0
  Image depth_m = {};  // 1 channel, along the camera's axis, > 0; +inf where there is no surface
};

struct PicturePass {
  bool shown = false;  // there is a picture
  GlTexture color = {}, depth_m = {};
  GlVertexArray no_vertices = {};
  ShaderProgram draw_color = {}, draw_depth = {};
  // Where drops refract it: as another camera at the same place sees it, filtered to its texels.
  ShaderProgram draw_view = {};
  GlBuffer views = {};
};

// Of the targets' size. refracted: it is drawn into views, too.
PicturePass make_picture_pass(const ScenePass& targets, bool refracted);

// The picture of the next frames, of the targets' size.
void set_picture(PicturePass& pass, const Picture& picture);

void draw_picture(const PicturePass& pass, const ScenePass& targets);

// With its targets.
// Over what is in a square target of another camera, as draw_view of realtime/scene_pass.h takes
// it: what the picture's camera sees. The pass is one that is refracted.
void draw_picture_view(const PicturePass& pass, const GpuCamera& picture_camera,
                       const GpuCamera& camera, const GlFramebuffer& target, int size_px);

PlannedPass plan_of(const PicturePass& pass, const ScenePass& targets);

}  // namespace pluvia
