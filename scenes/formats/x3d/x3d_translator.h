#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "base/all_failures.h"
#include "renderer/math/bounds.h"
#include "scenes/formats/x3d/document/x3d_document.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"
#include "scenes/formats/x3d/document/x3d_values.h"
#include "scenes/formats/x3d/geometry/x3d_polygons.h"
#include "scenes/formats/x3d/x3d_files.h"
#include "scenes/import/loaded_scene.h"
#include "scenes/import/warnings.h"
#include "scenes/mesh/pen.h"

namespace tessera {

/// Names of one kind, each given out once.
struct X3dNames {
  std::set<std::string> taken;
  std::map<std::string, int> next;  ///< the number that a wish is tried with
};

/// What the files share that make up one scene.
struct X3dBuild {
  /// Of groups, through USE, prototypes and Inlines: what the renderer follows, and some less.
  static constexpr int kMaxDepth = 180;

  const ReadOptions& options;
  X3dFiles files;
  LoadedScene out{};
  X3dNames object_names{}, material_names{}, texture_names{}, camera_names{};
  bool has_fog = false, has_navigation = false, headlight = true;
  int depth = 0;
  std::map<std::string, std::string> data_pictures{};  ///< what data: URIs hold, by the URI
  std::string placeholder{};  ///< the texture that stands for pictures which are missing
  v1::Camera view{};          ///< from which the scene is seen unless another one is asked for
  double framed_extent = 0;   ///< metres across all that a view is framed for

  /// Finds prototypes for a document of that folder, as X3dFiles names it. Refers to this.
  X3dPrototypeFinder prototype_finder(const std::string& folder);
  /// `wish`, or that with a number behind it; from now on it is taken.
  static std::string unique(X3dNames& names, const std::string& wish);
  void put(const Color& color, v1::Color* out_color) const;
};

/// Turns the nodes of one X3D document into parts of a scene.
class X3dTranslator {
 public:
  /// `folder` is the document's, as X3dFiles names it.
  X3dTranslator(const X3dDocument& document, X3dBuild& build, std::string folder)
      : document_(document),
        build_(build),
        out_(build.out),
        folder_(std::move(folder)),
        values_(document, warnings_) {}

  using Nodes = google::protobuf::RepeatedPtrField<v1::Node>;

  /// All that the file shows. `path` leads from the frame around it to the world; `unit` is that
  /// frame's, in metres.
  void add_all(const v1::Transform& path, double unit, Nodes& out);
  /// What only the first file has: settings and metadata.
  void finish();
  /// The first viewpoint of the file itself, else the one that a file without any has.
  v1::Camera first_view();
  /// About how far apart the points of the file itself are, in metres; for lines and points, which
  /// are as wide as the picture asks for. 0 where it has none of these.
  double rough_extent();

 private:
  // The graph (x3d_graph.cpp). `path` leads from the frame of the children to the world.
  void add_children(const X3dNode& parent, const v1::Transform& path, Nodes& out);
  std::vector<const X3dNode*> shown_children(const X3dNode& parent) const;
  void add_node(const X3dNode& node, const v1::Transform& path, Nodes& out);
  void add_instance(const X3dNode& node, const v1::Transform& path, Nodes& out);
  void fill_node(const X3dNode& node, const v1::Transform& path, v1::Node& out);
  /// Notes where the node stands in the file.
  void mark(const X3dNode& node, v1::Node& out);
  v1::Transform transform(const X3dNode& node) const;
  void add_inline(const X3dNode& node, const v1::Transform& path, v1::Node& out);
  std::string read_inline(const X3dNode& node, const std::string& url, bool takes_others,
                          const v1::Transform& path, v1::Node& out);
  void add_file(const std::string& file, const std::string& name, const v1::Transform& path);
  void check_names();
  void warn_unknown_field(size_t offset, const X3dNode& node, const X3dNodeType& type,
                          const std::string& name);
  void list_ignored();

  // Cameras, lights and what surrounds the scene (x3d_view.cpp, x3d_lights.cpp, x3d_sky.cpp).
  void add_camera(const X3dNode& node, const v1::Transform& path);
  /// Nothing where its frame is flat.
  std::optional<v1::Camera> make_camera(const X3dNode& node, const v1::Transform& path) const;
  bool find_view(const X3dNode& parent, const v1::Transform& path, int depth, v1::Camera& out);
  void add_points(const X3dNode& parent, const v1::Transform& path, int depth,
                  std::set<const X3dNode*>& seen, Bounds3& out) const;
  v1::Transform path_of_file() const;
  void add_light(const X3dNode& node, Nodes& out);
  void set_attenuation(const X3dNode& node, v1::Light& light);
  void set_background(const X3dNode& node, const v1::Transform& path);
  void set_sky(const X3dNode& node, v1::Background& background);
  void set_fog(const X3dNode& node, const v1::Transform& path);
  void finish_cameras();
  void set_settings();
  void set_metadata();

  // Shapes (x3d_shapes.cpp).
  void add_shape(const X3dNode& node, const v1::Transform& path, v1::Node& out);
  /// What decides over a geometry node's mesh beside itself; of lines used more than once the first
  /// use decides over their width.
  struct MeshLook {
    bool textured = false;
    const X3dNode* line_properties = nullptr;
    friend auto operator<=>(const MeshLook&, const MeshLook&) = default;
  };
  bool set_geometry(const X3dNode& geometry, const MeshLook& look, const v1::Transform& path,
                    v1::Shape& shape);
  const X3dMesh& mesh(const X3dNode& geometry, const MeshLook& look, const v1::Transform& path);
  Pen pen(const X3dNode* line_properties, const v1::Transform& path);

  // Materials (x3d_materials.cpp).
  /// What textures are looked up by: modes of a TextureCoordinateGenerator (18.4.8), but for uv.
  enum class Coordinates { uv, coord, coord_eye, sphere, sphere_local, camera_space_normal };
  static Coordinates coordinates_of(const X3dNode& geometry, const X3dValues& values);
  void set_coordinates(Coordinates coordinates, v1::Texture& texture) const;
  /// What decides over the material of a shape.
  struct Look {
    const X3dNode* appearance = nullptr;
    bool two_sided = false, colors = false, color_alpha = false, lines = false;
    Coordinates coordinates = Coordinates::uv;
    friend auto operator<=>(const Look&, const Look&) = default;
  };
  std::string material(const Look& look);
  v1::Material make_material(const Look& look, const X3dNode* node, bool back);
  v1::Material make_classic(const Look& look, const X3dNode& node, bool back);
  v1::Material make_unlit(const Look& look, const X3dNode* node);
  v1::Material make_physical(const Look& look, const X3dNode& node);
  void set_normal_map(const Look& look, const X3dNode& node, v1::Material& material);
  void set_alpha(const Look& look, v1::Material& material);
  double transparency(const Look& look, const X3dNode& node, const char* name) const;
  bool texture_replaces() const;

  // Textures (x3d_textures.cpp). All give a texture's name, or "" for none.
  std::string main_texture(const Look& look, const X3dNode* material, const char* field);
  std::string texture(const X3dNode* node, const Look& look, bool is_color);
  /// The picture that the first good URL names, as Image.file calls it.
  struct Picture {
    std::string file{};       ///< empty: there is none
    std::string reasons{};    ///< "'URL': why not" of each URL before it
    bool is_damaged = false;  ///< one of those is there and is no picture
    std::string note{};       ///< as of AssetFolder::Found
  };
  /// `node` says which file the URLs stand in.
  Picture find_picture(const X3dNode& node, const std::vector<std::string>& urls);
  std::string check_picture(const X3dNode& node, const std::string& url, bool takes_others,
                            Picture& out);
  std::string image_texture(const X3dNode& node, v1::Texture::Image image);
  std::string picture_texture(const Picture& picture, v1::Texture::Image image, size_t offset);
  std::string pixel_texture(const X3dNode& node, v1::Texture::Image image);
  std::string add_texture(v1::Texture texture, const std::string& wish);
  std::string placeholder_texture();
  void set_wrapping(const X3dNode& node, v1::Texture::Image& image) const;
  v1::Transform texture_transform(const X3dNode& node) const;
  std::string sky_texture(const X3dNode& node, const std::string& side);
  v1::Texture::Image::Encoding color_encoding() const;

  /// What URLs in the node are relative to.
  std::string folder_of(const X3dNode& node) const {
    return node.file ? X3dFiles::folder_of(*node.file) : folder_;
  }
  void put(const Color& color, v1::Color* out) const { build_.put(color, out); }

  const X3dDocument& document_;
  X3dBuild& build_;
  LoadedScene& out_;
  const std::string folder_;
  Warnings warnings_;
  AllFailures failures_{kMostFaults};
  X3dValues values_;

  std::map<const X3dNode*, std::string> objects_;  ///< by what is used more than once
  std::set<const X3dNode*> without_view_;          ///< groups that find_view has been through
  std::map<std::pair<const X3dNode*, MeshLook>, X3dMesh> meshes_;
  std::map<Look, std::string> materials_;
  std::map<std::tuple<const X3dNode*, const X3dNode*, Coordinates, bool>, std::string> textures_;
};

}  // namespace tessera
