// status, pause, resume, retry and cancel: questions and orders about jobs of a farm.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/all_failures.h"
#include "base/log.h"
#include "base/plural.h"
#include "cli/add_options.h"
#include "cli/command_line.h"
#include "cli/interrupt.h"
#include "cli/progress_display.h"
#include "cli/say.h"
#include "cli/waiting.h"
#include "client/job_client.h"
#include "front/farm_connection.h"
#include "front/job_name.h"
#include "front/job_orders.h"
#include "front/job_status.h"
#include "front/option_values.h"
#include "job/job.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

struct JobOptions {
  FarmConnection connection{.endpoint = kDefaultEndpoint};
  std::string job;
  bool as_json = false;
  bool wait = false;
  bool forget = false;
  bool all_failed = false;
  std::optional<int> priority;
};

/// A connection with what speaks over it.
struct Connection {
  explicit Connection(const FarmConnection& farm)
      : transport(connect(farm)), client(*transport, farm.endpoint, interrupted()) {}
  std::unique_ptr<ClientTransport> transport;
  FarmClient client;
};

void print_table(const v1::JobList& list) {
  static constexpr char kRow[] = "{:>5}  {:<9}  {:>8}  {:>9}  {:>15}  {:>5}  {:>9}  {}\n";
  say(kRow, "job", "state", "priority", "frames", "tiles", "done", "remaining", "name");
  for (const v1::JobStatus& job : list.jobs()) {
    const std::string why =
        job.waits_for().empty() ? "" : fmt::format("  (waits for {})", printable(job.waits_for()));
    const bool is_known = job.remaining_seconds() >= 0;
    say(kRow, job.job(), state_name(job), job.priority(),
        fmt::format("{}/{}", job.frames_done(), job.frames_total()),
        fmt::format("{}/{}", job.tiles_done(), job.tiles_total()),
        fmt::format("{} %", percent(job)), is_known ? duration_text(job.remaining_seconds()) : "",
        printable(job.name()) + why);
  }
  const bool any_waits = std::any_of(list.jobs().begin(), list.jobs().end(),
                                     [&](const auto& job) { return job.waits_for() == "workers"; });
  say("{}{}\n", counted(list.workers(), "worker"), any_waits ? ": jobs wait for some" : "");
}

void print_job(const v1::JobStatus& job) {
  const auto line = [](const char* name, const std::string& value) {
    say("{:<10} {}\n", name, value);
  };
  line("job", std::to_string(job.job()));
  line("name", printable(job.name()));
  line("state", state_name(job));
  if (!job.waits_for().empty()) line("waits for", printable(job.waits_for()));
  line("priority", fmt::format("{}, weight {}", job.priority(), job.weight()));
  line("frames", fmt::format("{} of {}", job.frames_done(), job.frames_total()));
  line("tiles", fmt::format("{} of {}, {} %", job.tiles_done(), job.tiles_total(), percent(job)));
  if (job.remaining_seconds() >= 0) {
    line("remaining", duration_text(job.remaining_seconds()));
  }
  // What holds all of it is told already.
  const bool is_told = job.waits_for().find(job.failure()) != std::string::npos;
  if (!is_told) {
    line(job.state() == v1::JobStatus::ENDED ? "failure" : "held", printable(job.failure()));
  }
  if (job.state() != v1::JobStatus::ENDED) line("workers", std::to_string(job.workers()));
}

/// Shows progress until the job has ended.
v1::JobStatus wait_for_end(FarmClient& client, const v1::JobQuery& query) {
  ProgressDisplay display(progress_style(stderr, false), stderr, "");
  for (;;) {
    v1::JobStatus status = ask_patiently([&] { return client.ask(query); });
    if (status.state() == v1::JobStatus::ENDED) return status;
    display.show(progress_of(status));
    client.wait(kAskEvery);
  }
}

ExitCode show_status(const JobOptions& options) {
  if (options.wait && options.job.empty())
    throw usage_error("status --wait: expected a job, by its number or name");
  catch_interrupts();
  configure_logging("warn", "status");
  Connection connection(options.connection);
  if (options.job.empty()) {
    const v1::JobList list = connection.client.list();
    if (!options.as_json) {
      print_table(list);
      return ExitCode::done;
    }
    say("{}\n", list_json(list).dump(2));
    return ExitCode::done;
  }
  v1::JobQuery query;
  query.set_job(find_job(connection.client, options.job, say_error));
  const v1::JobStatus status =
      options.wait ? wait_for_end(connection.client, query) : connection.client.ask(query);
  if (options.as_json) {
    say("{}\n", status_json(status).dump(2));
  } else {
    print_job(status);
  }
  return options.wait ? to_exit_code(status.exit_code()) : ExitCode::done;
}

ExitCode retry(const JobOptions& options) {
  catch_interrupts();
  configure_logging("warn", "retry");
  if (options.all_failed == !options.job.empty()) {
    throw usage_error("retry: expected a job, by its number or name, or --all-failed");
  }
  Connection connection(options.connection);
  std::vector<uint64_t> jobs;
  if (!options.all_failed) {
    jobs = {find_job_to_change(connection.client, options.job)};
  } else {
    const v1::JobList list = connection.client.list();
    for (const v1::JobStatus& job : list.jobs()) {
      if (may_be_retried(job)) jobs.push_back(job.job());
    }
    if (jobs.empty()) say("no job has failed or is held\n");
  }
  AllFailures failures;
  for (const uint64_t job : jobs) {
    failures.attempt([&] {
      v1::JobQuery query;
      query.set_job(job);
      query.set_action(v1::JobQuery::RETRY);
      say("job {} is {}\n", job, state_name(give_order(connection.client, query)));
    });
  }
  failures.throw_if_any();
  return ExitCode::done;
}

ExitCode order(const JobOptions& options, v1::JobQuery::Action action) {
  catch_interrupts();
  configure_logging("warn", "order");
  Connection connection(options.connection);
  v1::JobQuery query;
  query.set_job(find_job_to_change(connection.client, options.job));
  query.set_action(action);
  if (options.priority) query.set_priority(*options.priority);
  const v1::JobStatus status = give_order(connection.client, query, options.forget);
  if (options.forget) {
    forget_job(connection.client, query.job());
    say("job {} is forgotten\n", query.job());
  } else {
    say("job {} is {}\n", status.job(), state_name(status));
  }
  return ExitCode::done;
}

void add_job_argument(CLI::App& command, JobOptions& options, bool required) {
  command
      .add_option("JOB", options.job,
                  "The job, by its number or name; name:NAME where the name is a number")
      ->type_name("JOB")
      ->required(required);
  OptionList list;
  add_connection_options(list, options.connection);
  add_options(command, list);
}

void add_status_command(CLI::App& app, Action& action) {
  auto options = std::make_shared<JobOptions>();
  CLI::App* command = app.add_subcommand("status", "What a farm's jobs are at");
  command->footer(
      "Examples:\n"
      "  tessera status                  all jobs\n"
      "  tessera status 7                one of them\n"
      "  tessera status 7 --wait         its progress until it has ended; the exit code is its "
      "own\n"
      "  tessera status 7 --json | jq .state");
  add_job_argument(*command, *options, false);
  command->add_flag("--json", options->as_json, "As one JSON object");
  command->add_flag("--wait", options->wait, "Show the job's progress until it has ended");
  command->callback([options, &action] { action = [options] { return show_status(*options); }; });
}

void add_order(CLI::App& app, Action& action, const char* name, const std::string& text,
               const std::string& footer, v1::JobQuery::Action what) {
  auto options = std::make_shared<JobOptions>();
  CLI::App* command = app.add_subcommand(name, text);
  command->footer(footer);
  add_job_argument(*command, *options, true);
  if (what == v1::JobQuery::CANCEL) {
    command->add_flag("--forget", options->forget, "Delete the job too, and its tiles");
  } else {
    command
        ->add_option_function<std::string>(
            "--priority",
            [options](const std::string& typed) {
              options->priority =
                  static_cast<int>(parse_whole("--priority", typed, -kMostPriority, kMostPriority));
            },
            "And from now on this priority [as before]")
        ->type_name("N");
  }
  command->callback(
      [options, what, &action] { action = [options, what] { return order(*options, what); }; });
}

}  // namespace

void add_job_commands(CLI::App& app, Action& action) {
  add_status_command(app, action);
  add_order(app, action, "pause", "Give out no more tiles of a job",
            "Tiles that workers hold are finished and kept, unless another job needs the memory.\n"
            "Example:\n"
            "  tessera pause 7",
            v1::JobQuery::PAUSE);
  add_order(app, action, "resume", "Go on with a job that was paused",
            "Examples:\n"
            "  tessera resume 7\n"
            "  tessera resume 7 --priority 10     go on, before jobs of lower priority",
            v1::JobQuery::RESUME);
  auto options = std::make_shared<JobOptions>();
  CLI::App* command =
      app.add_subcommand("retry", "Render again what failed of a job, or try what is held now");
  command->footer(
      "Tiles that are done stay done. What is held is tried again by itself too, when what it "
      "lacks\n"
      "may be there.\n"
      "Examples:\n"
      "  tessera retry 7\n"
      "  tessera retry --all-failed         whatever failed or is held");
  add_job_argument(*command, *options, false);
  command->add_flag("--all-failed", options->all_failed, "All jobs that failed or are held");
  command->callback([options, &action] { action = [options] { return retry(*options); }; });
  add_order(app, action, "cancel", "End a job now",
            "Tiles that are done can still be fetched, with holes marked.\n"
            "Examples:\n"
            "  tessera cancel 7\n"
            "  tessera cancel 7 --forget          and delete what there is of it\n"
            "  tessera cancel --forget -- -o      a job whose name looks like an option",
            v1::JobQuery::CANCEL);
}

}  // namespace tessera
