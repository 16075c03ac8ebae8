// gicube-accuracy: measures the board's pictures against the double-precision reference and writes the tables of
// docs/studies/accuracy.md.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>

#include "scene/program/board_options.h"
#include "table.h"

namespace {

using namespace gicube::accuracy;

struct Options {
  std::string board = "emu:";
  std::string data = GICUBE_SOURCE_DIR "/../shared/data";
  std::string output;
  std::string size = "256x256";
  std::vector<std::string> scenes;
  int buckyball = 256;
  double step = 0.5;
  unsigned threads = 0;
};

void add_options(CLI::App& app, Options& options) {
  app.add_option("--board", options.board, "URI of the board")->capture_default_str();
  app.add_option("--data", options.data, "folder of the real scans; those that are not there are left out")
      ->capture_default_str();
  app.add_option("--output", options.output,
                 "folder of the tables, scenes.csv and quantisers.csv; the terminal if not given");
  app.add_option("--size", options.size, "image, pixels")->capture_default_str();
  app.add_option("--scene", options.scenes, "only this scene (repeatable)");
  app.add_option("--volume-size", options.buckyball, "voxels an edge of the buckyball")->capture_default_str();
  app.add_option("--step", options.step, "voxels")->capture_default_str();
  app.add_option("--threads", options.threads, "of the reference, 0 = one a core")->capture_default_str();
}

bool wanted(const Options& options, const std::string& name) {
  return options.scenes.empty() ||
         std::find(options.scenes.begin(), options.scenes.end(), name) != options.scenes.end();
}

void check_names(const Options& options, const std::vector<StudyScene>& scenes) {
  std::string names;
  for (const StudyScene& study : scenes) names += (names.empty() ? "" : ", ") + study.name;
  for (const std::string& name : options.scenes) {
    const auto is_name = [&](const StudyScene& study) { return study.name == name; };
    if (std::none_of(scenes.begin(), scenes.end(), is_name)) {
      throw CLI::ValidationError("--scene", "expected one of " + names + ", got " + name);
    }
  }
}

std::vector<Row> run(const Options& options) {
  const std::vector<int> size = gicube::samples::parse_sizes("--size", options.size, 2, 'x');
  std::vector<StudyScene> scenes = study_scenes(options.data, options.buckyball);
  check_names(options, scenes);
  std::vector<Row> rows;
  for (StudyScene& study : scenes) {
    if (!wanted(options, study.name)) continue;
    if (!study.available()) {
      std::cerr << study.name << ": left out, " << study.scene.volume.file.string() << " is not there\n";
      continue;
    }
    study.scene.view.width = size[0];
    study.scene.view.height = size[1];
    study.scene.view.step = options.step;
    gicube::Board board = gicube::Board::open(uri_for(study, options.board));
    rows.push_back({study.name, study.look, measure(gicube::samples::set_up(study.scene), board, options.threads)});
    std::cerr << fmt::format("{}: {:.1f} dB\n", study.name, rows.back().figures.board.psnr_db);
  }
  return rows;
}

void write(const std::string& text, const std::string& folder, const std::string& name) {
  if (folder.empty()) {
    std::cout << text << '\n';
    return;
  }
  const std::string path = folder + "/" + name;
  std::ofstream file(path);
  if (!(file << text).flush()) throw std::runtime_error(path + ": can't be written");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Accuracy of the board's fixed-point pictures");
  Options options;
  add_options(app, options);
  try {
    app.parse(argc, argv);
    setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 0);  // this program does not stand beside it
    const std::vector<Row> rows = run(options);
    write(scene_table(rows), options.output, "scenes.csv");
    write(quantiser_table(rows), options.output, "quantisers.csv");
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "gicube-accuracy: " << error.what() << '\n';
    return 1;
  }
}
