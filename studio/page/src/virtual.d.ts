/** The licences of all that is shipped, put together by build.mjs. */
declare module "virtual:licences" {
  const text: string;
  export default text;
}
