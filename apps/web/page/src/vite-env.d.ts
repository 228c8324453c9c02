/// <reference types="vite/client" />

/** Where the module in Rust is; `cargo xtask web` says which file that is. */
declare module "starbreak.wasm?url" {
  const address: string;
  export default address;
}
