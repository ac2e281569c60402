// Stands for "vendor" in the bundles of the pages: what vendor.js has left in the page.
module.exports = globalThis.skylimbVendor;
