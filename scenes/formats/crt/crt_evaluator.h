#pragma once

#include <deque>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "scenes/formats/crt/crt_attributes.h"
#include "scenes/formats/crt/crt_functions.h"
#include "scenes/formats/crt/crt_program.h"

namespace tessera {

/// The variables of a block. Alive while the block runs, longer where a macro was made in it.
struct CrtScope {
  struct Variable {
    CrtValue value;
    /// `a = b` outside of blocks makes a another name of b, as in the original.
    std::string_view alias;
  };
  std::unordered_map<std::string_view, Variable> variables;
  CrtScope* parent = nullptr;
  bool ends_assignment = false;  ///< of a macro, or the script: what is outside is only read
  bool captured = false;
};

/// Runs a script. What goes wrong is reported to the diagnostics; limits end the run.
class CrtEvaluator {
 public:
  static constexpr uint64_t kMaxSteps = 5'000'000;
  static constexpr uint64_t kMaxTurns = 500'000;  ///< of one loop
  static constexpr int kMaxCalls = 256;           ///< of macros inside each other
  static constexpr int kMaxDepth = 3000;          ///< of expressions, through all calls
  static constexpr size_t kMaxEntities = 250'000;

  /// `heap` and `diagnostics` must outlive this and the program. `keep_origins`: the program tells
  /// where entities were made.
  CrtEvaluator(CrtHeap& heap, CrtDiagnostics& diagnostics, bool keep_origins = false);
  /// `time` is the value of t: the number of the frame.
  CrtProgram run(const CrtSyntax& script, int32_t time);

 private:
  class OpenScope;
  /// Values of bare expressions, which a scene or a macro gathers.
  struct Yield {
    CrtValue value;
    CrtSpan where;
  };
  using Yields = std::vector<Yield>;

  /// A call or a turn that is under way.
  struct Making {
    CrtSpan where;
    uint32_t turn = 0;
    uint32_t number = 0;  ///< of CrtProgram::makings; 0 until an entity is made in it
  };
  /// One of `makings` while it lives.
  struct Under {
    Under(std::vector<Making>& makings, const Making& making) : makings_(makings) {
      makings_.push_back(making);
    }
    ~Under() { makings_.pop_back(); }
    Under(const Under&) = delete;
    Under& operator=(const Under&) = delete;
    std::vector<Making>& makings_;
  };

  /// Raises a count while it lives.
  struct Raised {
    explicit Raised(int& number) : number_(number) { ++number_; }
    ~Raised() { --number_; }
    Raised(const Raised&) = delete;
    Raised& operator=(const Raised&) = delete;
    int& number_;
  };

  // Statements.
  void run_top(const CrtSyntax& script);
  void run_block(const CrtSyntax& block, Yields* yields);
  void run_statement(const CrtSyntax& statement, Yields* yields);
  void run_loop(const CrtSyntax& loop, Yields* yields);
  void run_branch(const CrtSyntax& branch, Yields* yields);
  void run_settings(const CrtSyntax& settings);
  void run_scene(const CrtSyntax& scene);
  void add_to_scene(const Yield& yield);
  /// Of a loop or a branch: false where it failed.
  std::optional<bool> condition(const CrtSyntax& expression);

  // Expressions.
  CrtValue evaluate(const CrtSyntax& expression);
  void check_depth(CrtSpan where) const;
  CrtValue evaluate_leaf(const CrtSyntax& expression);
  /// Continues a left-leaning chain: `left` is the value of the node's first child.
  CrtValue apply(const CrtSyntax& node, const CrtValue& left);
  CrtValue literal(const CrtSyntax& expression);
  CrtValue list(const CrtSyntax& expression);
  CrtValue group(const CrtSyntax& expression);
  CrtValue object(const CrtSyntax& expression);
  CrtValue ternary(const CrtSyntax& expression);
  CrtValue logical(const CrtSyntax& node, const CrtValue& left);
  CrtValue index(const CrtSyntax& node, const CrtValue& left);
  CrtValue assign(const CrtSyntax& node);
  std::vector<CrtAttribute> attributes(const CrtSyntax& expression);

  // Calls and modifiers.
  CrtValue call_by_name(const CrtSyntax& node);
  CrtValue call(const CrtMacro& macro, std::vector<CrtValue> arguments, CrtSpan where);
  std::vector<CrtValue> arguments(const CrtSyntax& node);
  CrtValue modify(const CrtSyntax& node, const CrtValue& left);
  CrtValue modified(const CrtValue& value, const v1::Transform& modifiers, CrtSpan where);
  void add_modifier(const CrtSyntax& modifier, v1::Transform& to, bool& failed);

  // Variables.
  /// Behind all aliases; null where there is none.
  CrtScope::Variable* find(std::string_view name);
  CrtValue variable(const CrtSyntax& identifier);
  void name_thing(const CrtValue& value, std::string_view name);
  CrtScope* open_scope(CrtScope* parent);
  void close_scope(CrtScope* scope);

  /// Notes where the entity, if it is one that is not known yet, was made.
  CrtValue note_made(CrtValue value, CrtSpan where);

  void step(CrtSpan where);
  /// Inside macros, loops and branches, which the original does not have, && || and ?: leave out
  /// what they do not need, and no variable is another's alias. Elsewhere everything is evaluated,
  /// as in the original: rand() goes on.
  bool in_block() const { return block_depth_ > 0; }

  CrtHeap& heap_;
  CrtDiagnostics& diagnostics_;
  CrtFunctions functions_;
  CrtProgram program_;
  std::deque<CrtScope> scopes_;
  std::vector<CrtScope*> free_scopes_;
  CrtScope* scope_ = nullptr;
  uint64_t steps_ = 0;
  int depth_ = 0, calls_ = 0, block_depth_ = 0;
  uint64_t leaves_ = 0;
  bool keeps_origins_ = false;
  std::vector<Making> makings_;
};

}  // namespace tessera
