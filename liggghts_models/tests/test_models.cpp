// SPDX-License-Identifier: GPL-2.0-or-later
//
// Pair style, fixes and C interface in LIGGGHTS, on one rank and on more: what is put in comes out, also
// after elements went to other ranks, and no fault crosses the C interface as an exception.
#include <mpi.h>

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "atom.h"
#include "capi.h"
#include "comm.h"
#include "fix_floe_integrate.h"
#include "fix_floe_walls.h"
#include "history.h"
#include "lammps.h"
#include "liggghts_error.h"
#include "neighbor.h"
#include "pair_floe.h"
#include "pair_gran.h"
#include "plugin.h"
#include "random.h"

using namespace LAMMPS_NS;

namespace {

using Pair = std::pair<long long, long long>;
using Table = std::map<Pair, std::vector<double>>;

// Rows and columns of discs, and their distance (m): they overlap a little.
constexpr int along = 8, across = 3;
constexpr double spacing = 2000.0, radius = 1002.0;

int ranks() {
  int size;
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  return size;
}

// Parts of the layout, each a list of names.
std::vector<std::vector<std::string>> layout() {
  std::vector<std::vector<std::string>> parts;
  std::istringstream text(floe_layout());
  for (std::string part; std::getline(text, part, ';');) {
    std::istringstream words(part);
    parts.emplace_back();
    for (std::string word; words >> word;) parts.back().push_back(word);
  }
  return parts;
}

struct Session {
  void *instance = nullptr;

  explicit Session(const std::string &terms) {
    const char *words[] = {"test", "-screen", "none", "-log", "none"};
    MPI_Comm world = MPI_COMM_WORLD;
    REQUIRE(floe_open(5, const_cast<char **>(words), &world, &instance) == 0);
    for (const std::string &line :
         {std::string("units si"), std::string("dimension 2"), std::string("atom_style granular"),
          std::string("boundary p m p"), std::string("newton off"),
          std::string("communicate single vel yes"), std::string("processors * 1 1"),
          std::string("region box block 0 16000 -2000 6000 -2600 2600 units box"),
          std::string("create_box 2 box"), std::string("neighbor 200 bin"),
          std::string("neigh_modify delay 0 every 1 check yes"),
          "pair_style gran model floe " + terms, std::string("pair_coeff * *"),
          std::string("timestep 1"),
          std::string("fix motion all floe/integrate thickness 1 fused yes")}) {
      command(line);
    }
  }
  ~Session() { floe_close(instance); }
  LAMMPS *lmp() const { return static_cast<LAMMPS *>(instance); }
  void command(const std::string &line) {
    const int failed = floe_command(instance, line.c_str());
    CAPTURE(line);
    CAPTURE(std::string(floe_error()));
    REQUIRE(failed == 0);
  }
  // All drift alike: nothing between them changes.
  void create(double speed) {
    const std::vector<std::string> names = layout()[0];
    std::vector<long long> ids;
    std::vector<signed char> types(along * across, 1);
    std::vector<double> columns;
    for (int k = 0; k < along * across; ++k) {
      ids.push_back(k + 1);
      const std::map<std::string, double> values{{"x", spacing * (k % along) + 500.0},
                                                 {"y", spacing * (k / along)},
                                                 {"u", speed},
                                                 {"radius", radius},
                                                 {"mass", 2.9e9},
                                                 {"thickness", 1.0 + 0.01 * k},
                                                 {"ice_area", 3.0e6 + k},
                                                 {"cover", 1.0 - 0.01 * k},
                                                 {"ridged_area", 10.0 * k},
                                                 {"ocean_impulse_y", 1.0 * k}};
      for (const std::string &name : names) {
        columns.push_back(values.count(name) ? values.at(name) : 0.0);
      }
    }
    REQUIRE(floe_create_elements(instance, along * across, ids.data(), types.data(),
                                 columns.data()) == 0);
    command("run 0 post no");
  }
  void put(const Table &bonds, const Table &contacts) {
    std::vector<long long> ids[2];
    std::vector<double> rows[2];
    const Table *tables[2] = {&bonds, &contacts};
    for (int t = 0; t < 2; ++t) {
      for (const auto &entry : *tables[t]) {
        ids[t].push_back(entry.first.first);
        ids[t].push_back(entry.first.second);
        rows[t].insert(rows[t].end(), entry.second.begin(), entry.second.end());
      }
    }
    REQUIRE(floe_put_pairs(instance, bonds.size(), ids[0].data(), rows[0].data(), contacts.size(),
                           ids[1].data(), rows[1].data()) == 0);
  }
  // Bonds and contacts for which this rank speaks.
  std::array<Table, 2> get() {
    long long n[2];
    REQUIRE(floe_count_pairs(instance, &n[0], &n[1]) == 0);
    std::vector<long long> ids[2];
    std::vector<double> rows[2];
    const std::size_t width[2] = {layout()[1].size(), layout()[2].size()};
    for (int t = 0; t < 2; ++t) {
      ids[t].resize(2 * n[t]);
      rows[t].resize(width[t] * n[t]);
    }
    REQUIRE(floe_get_pairs(instance, ids[0].data(), rows[0].data(), ids[1].data(),
                           rows[1].data()) == 0);
    std::array<Table, 2> out;
    for (int t = 0; t < 2; ++t) {
      for (long long k = 0; k < n[t]; ++k) {
        const double *row = rows[t].data() + width[t] * k;
        out[t][{ids[t][2 * k], ids[t][2 * k + 1]}].assign(row, row + width[t]);
      }
    }
    return out;
  }
};

// What this rank holds of a table; how many rows all ranks hold of it.
void check_rows(const Table &found, const Table &wanted) {
  long long own = found.size(), all = 0;
  MPI_Allreduce(&own, &all, 1, MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
  CHECK(all == static_cast<long long>(wanted.size()));
  for (const auto &entry : found) {
    CAPTURE(entry.first.first);
    CAPTURE(entry.first.second);
    REQUIRE(wanted.count(entry.first) == 1);
    CHECK(entry.second == wanted.at(entry.first));
  }
}

// Neighbours in a row are bonded (of the last and the first, across the box), those in a column in
// contact. Numbers differ in each pair and column; bonds and contacts are at rest.
std::array<Table, 2> tables(bool ridging) {
  Uniform u(41);
  std::array<Table, 2> out;
  const auto parts = layout();
  for (int k = 0; k < along * across; ++k) {
    const int next = k % along == along - 1 ? k - along + 1 : k + 1;
    const long long lo = std::min(k, next) + 1, hi = std::max(k, next) + 1;
    // From lo to hi, which across the box lies to the left.
    const double side = next > k ? 1.0 : -1.0, half = u(100, 900), place = u(900, 1100);
    const std::map<std::string, double> bond{{"span", spacing},
                                             {"thickness", u(0.5, 2)},
                                             {"crack_a", u(0, 0.3)},
                                             {"crack_b", u(0, 0.3)},
                                             {"lo_ax", side * place},
                                             {"lo_ay", -side * half},
                                             {"lo_bx", side * place},
                                             {"lo_by", side * half},
                                             {"hi_ax", side * (place - spacing)},
                                             {"hi_ay", -side * half},
                                             {"hi_bx", side * (place - spacing)},
                                             {"hi_by", side * half}};
    for (const std::string &name : parts[1]) out[0][{lo, hi}].push_back(bond.at(name));
    if (k + along >= along * across) continue;
    const std::map<std::string, double> contact{{"slip", 0.0},
                                                {"rest_overlap", u(5, 9)},
                                                {"ridge_closing", u(0, 50)},
                                                {"ridge_thickness", u(0.5, 2)},
                                                {"ridge_length", u(500, 900)}};
    for (const std::string &name : parts[2]) {
      const bool ridge = name.compare(0, 6, "ridge_") == 0;
      out[1][{k + 1, k + 1 + along}].push_back(ridge && !ridging ? 0.0 : contact.at(name));
    }
  }
  return out;
}

}  // namespace

TEST_CASE("pairs: what is put in comes out, and stays through new lists and exchanges") {
  const std::string with = " contact_damping 0 bond_damping 0 reach 1.2";
  for (const bool ridging : {true, false}) {
    CAPTURE(ridging);
    Session run("bonds yes friction yes ridging " + std::string(ridging ? "yes" : "no") + with);
    run.create(50.0);
    std::array<Table, 2> wanted = tables(ridging);
    // Without ridging the rest overlap falls to the overlap as it is, 4 m.
    if (!ridging) {
      for (auto &row : wanted[1]) row.second[1] = 3.0 + 0.01 * row.first.first;
    }
    run.put(wanted[0], wanted[1]);
    for (int t = 0; t < 2; ++t) check_rows(run.get()[t], wanted[t]);
    run.command("run 0 post no");
    for (int t = 0; t < 2; ++t) check_rows(run.get()[t], wanted[t]);
    if (!ridging) continue;  // contacts push then
    // Once around the box: every pair comes to another rank and over the end of the box.
    const long long before = run.lmp()->neighbor->ncalls;
    run.command("run 330 post no");
    CHECK(run.lmp()->neighbor->ncalls > before + 50);
    for (int t = 0; t < 2; ++t) check_rows(run.get()[t], wanted[t]);
    long long all = 0, own = floe_count_elements(run.instance);
    MPI_Allreduce(&own, &all, 1, MPI_LONG_LONG, MPI_SUM, MPI_COMM_WORLD);
    CHECK(all == along * across);
  }
}

TEST_CASE("elements take what is theirs to another rank") {
  Session run("bonds no");
  run.create(50.0);
  run.command("run 330 post no");
  const std::vector<std::string> names = layout()[0];
  const long long n = floe_count_elements(run.instance);
  std::vector<long long> ids(n);
  std::vector<signed char> types(n);
  std::vector<double> columns(n * names.size());
  REQUIRE(floe_get_elements(run.instance, ids.data(), types.data(), columns.data()) == 0);
  for (long long k = 0; k < n; ++k) {
    const double *row = columns.data() + k * names.size();
    const auto value = [&](const std::string &name) {
      return row[std::find(names.begin(), names.end(), name) - names.begin()];
    };
    const double number = static_cast<double>(ids[k] - 1);
    CHECK(value("thickness") == 1.0 + 0.01 * number);
    CHECK(value("ice_area") == 3.0e6 + number);
    CHECK(value("cover") == 1.0 - 0.01 * number);
    CHECK(value("ridged_area") == 10.0 * number);
    CHECK(value("ocean_impulse_y") == 1.0 * number);
    CHECK(value("radius") == radius);
  }
}

TEST_CASE("forces of the list: keywords turn them on, sums stand in their place and add up") {
  std::vector<std::string> names;
  std::istringstream words(floe_sum_names());
  for (std::string word; words >> word;) names.push_back(word);
  Session run("bonds no");
  run.create(0.4);
  const auto sums = [&] {
    std::vector<double> own(names.size()), all(names.size());
    REQUIRE(floe_sums(run.instance, own.data(), static_cast<int>(own.size())) == 0);
    MPI_Allreduce(own.data(), all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM,
                  MPI_COMM_WORLD);
    std::map<std::string, double> out;
    for (std::size_t k = 0; k < names.size(); ++k) out[names[k]] = all[k];
    return out;
  };
  run.command("run 20 post no");
  CHECK(sums().at("dissipation_seabed") == 0.0);
  // 2 m of water: discs of 1 m and more touch the ground.
  run.command("fix_modify motion seabed yes keel_ratio 8 seabed_creep 5e-5 depth 2");
  const std::map<std::string, double> before = sums();
  run.command("run 20 post no");
  const std::map<std::string, double> after = sums();
  const double lost = after.at("dissipation_seabed"), given = after.at("impulse_seabed_x");
  CHECK(lost > 0.0);
  CHECK(given < 0.0);
  const double slower = after.at("momentum_x") - before.at("momentum_x");
  CHECK(slower == doctest::Approx(given).epsilon(1e-9));
  const double cooler = after.at("kinetic") - before.at("kinetic");
  const double works = after.at("work_contact") - before.at("work_contact") - lost;
  CHECK(cooler == doctest::Approx(works).epsilon(1e-9));
}

TEST_CASE("contacts with walls: what is put in comes out, and is packed and unpacked whole") {
  Session run("bonds no ridging yes contact_damping 0");
  run.create(0.0);
  run.command("fix walls all floe/walls");
  // One wall below the lowest row: a plane with the ice above it.
  const std::map<std::string, double> face{
      {"ax", 0.0}, {"ay", -1000.0}, {"bx", 1.0}, {"by", -1000.0}};
  std::vector<long long> numbers;
  std::vector<double> columns;
  const auto parts = layout();
  for (const std::string &name : parts[3]) {
    numbers.push_back(name == "plane" ? 1 : name == "wall" ? 0 : -1);
  }
  for (const std::string &name : parts[4]) {
    columns.push_back(face.count(name) ? face.at(name) : 0.0);
  }
  REQUIRE(floe_set_walls(run.instance, 1, 1, numbers.data(), columns.data()) == 0);
  run.command("run 0 post no");
  std::vector<long long> ids;
  std::vector<double> rows;
  const std::size_t width = layout()[2].size();
  Table wanted;
  for (int k = 0; k < along; ++k) {
    ids.push_back(k + 1);
    ids.push_back(0);
    for (std::size_t c = 0; c < width; ++c) {
      rows.push_back(c == 0 ? 0.0 : 3.0 + 0.1 * k + 0.01 * static_cast<double>(c));
      wanted[{k + 1, 0}].push_back(rows.back());
    }
  }
  REQUIRE(floe_put_wall_contacts(run.instance, along, ids.data(), rows.data()) == 0);
  run.command("run 0 post no");
  const auto get = [&] {
    const long long n = floe_count_wall_contacts(run.instance);
    std::vector<long long> who(2 * n);
    std::vector<double> what(width * n);
    REQUIRE(floe_get_wall_contacts(run.instance, who.data(), what.data()) == 0);
    Table out;
    for (long long k = 0; k < n; ++k) {
      const double *row = what.data() + width * k;
      out[{who[2 * k], who[2 * k + 1]}].assign(row, row + width);
    }
    return out;
  };
  check_rows(get(), wanted);
  // As on the way to another rank.
  FixFloeWalls *walls = floe::find_parts(run.lmp()).walls;
  walls->pre_exchange();
  CHECK(get().empty());
  double packed[100];
  for (int i = 0; i < run.lmp()->atom->nlocal; ++i) {
    const int size = walls->pack_exchange(i, packed);
    CHECK(walls->unpack_exchange(i, packed) == size);
  }
  walls->setup_pre_force(0);
  walls->setup(0);
  check_rows(get(), wanted);
}

TEST_CASE("lists that were made behind the pair style's back end the run") {
  if (ranks() > 1) return;  // there it ends all ranks
  Session run("bonds yes reach 1.2");
  run.create(0.0);
  const std::array<Table, 2> wanted = tables(false);
  run.put(wanted[0], {});
  run.command("run 1 post no");
  long long bonds, contacts;
  REQUIRE(floe_count_pairs(run.instance, &bonds, &contacts) == 0);
  CHECK(bonds == along * across);
  run.lmp()->neighbor->build();
  CHECK(floe_count_pairs(run.instance, &bonds, &contacts) == 1);
  CHECK(std::string(floe_error()).find("new lists of neighbours were made") != std::string::npos);
  CHECK(floe_command(run.instance, "run 1 pre no post no") == 1);
  floe::find_parts(run.lmp()).floe->forget_records();
  CHECK(floe_count_pairs(run.instance, &bonds, &contacts) == 0);
}

TEST_CASE("C interface: what is not set up is a sentence, in every function") {
  const auto check = [](void *instance) {
    long long whole[8] = {};
    double real[64] = {};
    signed char type[1] = {1};
    const auto failed = [](long long result, const std::string &name) {
      CAPTURE(name);
      CHECK((result == 1 || result == -1));
      CHECK(std::string(floe_error()).find("there ") == 0);
    };
    failed(floe_set_start_time(instance, 0.0), "floe_set_start_time");
    failed(floe_create_elements(instance, 0, whole, type, real), "floe_create_elements");
    failed(floe_get_elements(instance, whole, type, real), "floe_get_elements");
    failed(floe_put_pairs(instance, 0, whole, real, 0, whole, real), "floe_put_pairs");
    failed(floe_count_pairs(instance, whole, whole + 1), "floe_count_pairs");
    failed(floe_get_pairs(instance, whole, real, whole, real), "floe_get_pairs");
    failed(floe_set_walls(instance, 0, 0, whole, real), "floe_set_walls");
    failed(floe_put_wall_contacts(instance, 0, whole, real), "floe_put_wall_contacts");
    failed(floe_set_forcing(instance, 1, 1, 1, real, 0, 1, 0, 1, real, real, 0, 0),
           "floe_set_forcing");
    failed(floe_set_depth(instance, real), "floe_set_depth");
    failed(floe_sums(instance, real, 64), "floe_sums");
    failed(floe_fault(instance, whole, real), "floe_fault");
  };
  const char *words[] = {"test", "-screen", "none", "-log", "none"};
  MPI_Comm world = MPI_COMM_WORLD;
  void *bare = nullptr;
  REQUIRE(floe_open(5, const_cast<char **>(words), &world, &bare) == 0);
  check(bare);
  CHECK(floe_count_elements(bare) == 0);
  CHECK(floe_count_wall_contacts(bare) == 0);
  if (ranks() == 1) {
    CHECK(floe_command(bare, "no such command") == 1);
    CHECK(std::string(floe_error()) != "");
  }
  CHECK(floe_close(bare) == 0);
}

TEST_CASE("C interface: without LIGGGHTS all fail in words") {
  long long whole[8] = {};
  double real[8] = {};
  const auto failed = [](long long result, long long wanted) {
    CHECK(result == wanted);
    CHECK(std::string(floe_error()) == "no LIGGGHTS is open");
  };
  failed(floe_close(nullptr), 1);
  failed(floe_command(nullptr, "run 0"), 1);
  failed(floe_divide(nullptr, real, real), 1);
  failed(floe_count_elements(nullptr), -1);
  failed(floe_count_wall_contacts(nullptr), -1);
  failed(floe_get_wall_contacts(nullptr, whole, real), 1);
  failed(floe_wall_forces(nullptr, real, real), 1);
  failed(floe_fault(nullptr, whole, real), 1);
  // Nothing that is thrown gets out.
  CHECK(floe::guarded([] { throw 7; }) == 1);
  CHECK(std::string(floe_error()) == "an error without words");
  CHECK(floe::counted([]() -> long long { throw std::bad_alloc(); }) == -1);
}
