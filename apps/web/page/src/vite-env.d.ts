/// <reference types="vite/client" />

// Where the modules in Rust are; `cargo xtask web` says in which folder.
declare module "glass.wasm?url" {
  const address: string;
  export default address;
}
declare module "detector.wasm?url" {
  const address: string;
  export default address;
}
