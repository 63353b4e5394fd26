#!/usr/bin/env bash
# Makes the keys of a farm in Kubernetes, in the folder FOLDER (which is to be kept: client.key and
# farm.pub are for whoever submits), and the secrets that the pods have of them. Each worker's pod
# makes its own key and enrols it by one of 512 tokens, which last for 90 days: for new ones, delete
# FOLDER/worker.tokens and say it again.
#   deploy/kubernetes/make-secrets.sh FOLDER
set -euo pipefail
folder=${1:?usage: make-secrets.sh FOLDER}
tessera=${TESSERA:-tessera}

umask 077
mkdir -p "$folder"
cd "$folder"
if [[ ! -e farm.allow ]]; then
  "$tessera" keygen farm.key >/dev/null
  "$tessera" keygen client.key --role submitter >farm.allow.new
  token() { od -An -v -N24 -tx1 /dev/urandom | tr -d ' \n'; }
  token >metrics.token
  echo "$(cat metrics.token) viewer metrics" >http.tokens
  echo "$(token) submitter page" >>http.tokens
  mv farm.allow.new farm.allow
fi
if [[ ! -e worker.tokens ]]; then
  "$tessera" keygen worker.tokens.new --name worker --tokens 512 --for 90d >tokens.allow
  # The tokens before these let in nobody new. A pod that is enrolled stays so.
  grep -v ' enrol:worker ' farm.allow | cat - tokens.allow >farm.allow.new
  mv farm.allow.new farm.allow
  mv worker.tokens.new worker.tokens
  rm tokens.allow
fi
secret() {
  kubectl create secret generic --namespace tessera --dry-run=client --output yaml "$@" |
    kubectl apply --filename -
}
kubectl create namespace tessera --dry-run=client --output yaml | kubectl apply --filename -
secret tessera-coordinator --from-file=farm.key --from-file=farm.allow --from-file=http.tokens
secret tessera-enrol --from-file=worker.tokens
secret tessera-worker --from-file=farm.pub
# For whoever reads /metrics: KEDA, Prometheus.
secret tessera-metrics --from-file=token=metrics.token
