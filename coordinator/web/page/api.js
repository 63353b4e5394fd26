// Requests to api/v1 of the coordinator that served this page, from wherever that is: a proxy may serve
// all of it below a path.
export const API = "api/v1/";

let token = sessionStorage.getItem("token") ?? "";

export class Refused extends Error {}

export function signIn(typed) {
  token = typed;
  sessionStorage.setItem("token", token);
}

async function request(path, options = {}) {
  const headers = { ...options.headers };
  if (token) headers.Authorization = `Bearer ${token}`;
  const response = await fetch(API + path, {
    ...options, headers, signal: AbortSignal.timeout(8000),
  });
  if (response.status === 401) throw new Refused("a token is needed");
  return response;
}

async function complain(response) {
  const what = await response.json().catch(() => ({}));
  throw new Error(what.error || `the coordinator answered ${response.status}`);
}

export async function get(path) {
  const response = await request(path);
  if (!response.ok) await complain(response);
  return response.json();
}

/// { bitmap, tag } of a picture, or null where it is still the one of `tag`, or there is none yet.
export async function getPicture(path, tag) {
  const response = await request(path, { headers: tag ? { "If-None-Match": tag } : {}, cache: "no-store" });
  if (response.status === 304 || response.status === 204) return null;
  if (!response.ok) await complain(response);
  return { bitmap: await createImageBitmap(await response.blob()), tag: response.headers.get("ETag") };
}

export async function order(job, what, value = {}) {
  const response = await request(`jobs/${job}/${what}`, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value),
  });
  if (!response.ok) await complain(response);
  return response.json();
}

export async function download(path, name) {
  const response = await request(path);
  if (!response.ok) await complain(response);
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await response.blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
