#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "proto/transport/transport.h"
#include "proto/wire/frame.h"

namespace tessera::testing {

/// A coordinator in one function, which answers each message of a client at once, or not at all.
class AnsweringTransport : public ClientTransport {
 public:
  void connect_bulk(const std::string&) override {}
  void wait(std::chrono::milliseconds) override {}
  void reconnect() override {}
  void wake() override {}
  void send(Channel, MessageBytes bytes) override {
    const auto message = decode(bytes, max_message_bytes(Channel::control));
    ASSERT_TRUE(message);
    auto status = answer(*message);
    if (!status) return;
    v1::Envelope reply;
    *reply.mutable_job_status() = *std::move(status);
    reply.mutable_job_status()->set_question(message->job_query().question());
    const auto encoded = std::make_shared<const MessageBytes>(encode(reply));
    incoming_.push_back({Channel::control, {}, std::as_bytes(std::span(*encoded)), encoded});
  }
  std::optional<ReceivedMessage> receive() override {
    if (incoming_.empty()) return std::nullopt;
    ReceivedMessage message = std::move(incoming_.front());
    incoming_.pop_front();
    return message;
  }

 private:
  virtual std::optional<v1::JobStatus> answer(const v1::Envelope& message) = 0;

  std::deque<ReceivedMessage> incoming_;
};

}  // namespace tessera::testing
