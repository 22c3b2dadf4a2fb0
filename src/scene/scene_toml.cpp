#include "scene/scene_toml.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <map>

#include "scene/scene_setting.h"

namespace tellurion::scene {
namespace {

using Code = io::Failure::Code;

class SceneToml {
 public:
  SceneToml(std::string_view text, const std::string& path) : path_(path), root_(toml::parse(text, path)) {}

  /// As if the file said so. Values are TOML; what is not, is a text.
  void set(const Setting& setting) {
    toml::table* at = &root_;
    std::string_view list;
    for (std::size_t i = 0; i + 1 < setting.path.size(); ++i) {
      const std::string& key = setting.path[i];
      toml::node* node = list.empty() ? at->get(key) : layerOf(list, key, setting);
      if (node == nullptr) node = &put(*at, key, "{}", setting);
      list = list.empty() && node->is_array() ? std::string_view(key) : std::string_view();
      if (!list.empty()) continue;
      at = node->as_table();
      if (at == nullptr)
        complain(whereOf(setting), fmt::format("'{}' of the scene has nothing in it that could be set", key));
    }
    const std::string value = isPlainValue(setting.value) ? setting.value : tomlText(setting.value);
    textsSet_[&put(*at, setting.path.back(), value, setting)] = setting.value;
  }

  Entry entries() const { return entry(root_, "", ""); }

 private:
  static std::string whereOf(const Setting& setting) { return "--set " + setting.written; }

  toml::node* layerOf(std::string_view list, std::string_view which, const Setting& setting) {
    toml::array* nodes = root_.get(list)->as_array();
    std::vector<LayerNames> layers;
    for (const toml::node& node : *nodes) {
      if (!node.is_table()) complain(placeOf(node.source()), fmt::format("'{}' must be a table", list));
      const auto text = [&](std::string_view key) { return (*node.as_table())[key].value_or(std::string()); };
      layers.push_back({.name = text("name"), .source = text("source"), .layer = text("layer")});
      const bool isDerived = layers.back().name.empty() && layers.back().source.empty();
      if (isDerived) layers.back().name = text("type");
    }
    const auto meant = layerMeant(which, layers);
    if (!meant) complain(whereOf(setting), meant.error().message);
    return nodes->get(*meant);
  }

  /// What is put into the scene has the setting as its place, for messages.
  static toml::node& put(toml::table& table, std::string_view key, const std::string& value, const Setting& setting) {
    toml::table parsed = toml::parse("value = " + value, whereOf(setting));
    const toml::key placed(key, toml::source_region(parsed.begin()->first.source()));
    return parsed.get("value")->visit(
        [&](auto& typed) -> toml::node& { return table.insert_or_assign(placed, std::move(typed)).first->second; });
  }

  static bool isPlainValue(const std::string& text) {
    try {
      const toml::table parsed = toml::parse("value = " + text);
      const toml::node* value = parsed.size() == 1 ? parsed.get("value") : nullptr;
      return value != nullptr && !value->is_date() && !value->is_date_time() && !value->is_time();
    } catch (const toml::parse_error&) {
      return false;
    }
  }

  std::string placeOf(const toml::source_region& at) const {
    const bool isSet = at.path && *at.path != path_;
    return isSet ? *at.path : fmt::format("{}:{}:{}", path_, at.begin.line, at.begin.column);
  }

  Entry entry(const toml::node& node, std::string_view key, const std::string& keyWhere) const {
    Entry out{.key = std::string(key),
              .value = {},
              .parts = {},
              .written = {},
              .where = placeOf(node.source()),
              .keyWhere = keyWhere};
    if (const auto set = textsSet_.find(&node); set != textsSet_.end()) out.written = set->second;
    if (const auto* boolean = node.as_boolean()) out.value = boolean->get();
    if (const auto* whole = node.as_integer()) out.value = whole->get();
    if (const auto* real = node.as_floating_point()) out.value = real->get();
    if (const auto* text = node.as_string()) out.value = text->get();
    if (const toml::array* list = node.as_array()) {
      out.shape = Entry::Shape::list;
      for (const toml::node& each : *list)
        out.parts.push_back(entry(each, key, keyWhere));
    }
    if (const toml::table* table = node.as_table()) {
      out.shape = Entry::Shape::table;
      for (const auto& [name, value] : *table)
        out.parts.push_back(entry(value, name.str(), placeOf(name.source())));
    }
    return out;
  }

  std::string path_;
  toml::table root_;
  std::map<const toml::node*, std::string> textsSet_;
};

}  // namespace

io::Result<Entry> readToml(std::string_view text, const std::string& path, std::span<const std::string> settings) {
  try {
    SceneToml scene(text, path);
    for (const std::string& written : settings) {
      const auto setting = parseSetting(written);
      if (!setting) return tl::unexpected(setting.error());
      scene.set(*setting);
    }
    return scene.entries();
  } catch (const toml::parse_error& e) {
    const auto at = e.source().begin;
    return io::fail(Code::invalidArgument, std::string(e.description()),
                    fmt::format("{}:{}:{}", path, at.line, at.column));
  } catch (EntryFault& fault) {
    return tl::unexpected(std::move(fault.failure));
  }
}

}  // namespace tellurion::scene
