import { defineConfig } from 'vite'

// Three files with fixed names: the program embeds them (studio/embed.cmake).
export default defineConfig({
  base: '/',
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact', legalComments: 'none' },
  build: {
    target: 'es2022',
    modulePreload: false,
    cssCodeSplit: false,
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 1500,
    rollupOptions: {
      output: {
        entryFileNames: 'studio.js',
        chunkFileNames: 'studio-[name].js',
        assetFileNames: 'studio[extname]',
        manualChunks: { three: ['three', 'three-mesh-bvh'] },
      },
    },
  },
})
