// What gicube-smi doctor looks at, one step after the other, and what it advises.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace gicube::smi {

struct Step {
  enum class Outcome { kGood, kBad, kNote } outcome;
  std::string question;
  std::string answer;
  std::string advice;  // empty: none
};

class Diagnosis {
 public:
  void good(std::string question, std::string answer) { add(Step::Outcome::kGood, question, answer, ""); }
  void note(std::string question, std::string answer) { add(Step::Outcome::kNote, question, answer, ""); }
  void bad(std::string question, std::string answer, std::string advice) {
    add(Step::Outcome::kBad, question, answer, advice);
    healthy_ = false;
  }

  const std::vector<Step>& steps() const { return steps_; }
  bool healthy() const { return healthy_; }

 private:
  void add(Step::Outcome outcome, std::string& question, std::string& answer, std::string advice) {
    steps_.push_back({outcome, std::move(question), std::move(answer), std::move(advice)});
  }

  std::vector<Step> steps_;
  bool healthy_ = true;
};

// Before a board is opened. False if that can't go well; the diagnosis says why.
bool look_for_program(Diagnosis& diagnosis);                            // emu:
bool look_at_socket(const std::string& path, Diagnosis& diagnosis);     // unix:
bool look_at_port(const std::string& host_port, Diagnosis& diagnosis);  // tcp:

}  // namespace gicube::smi
