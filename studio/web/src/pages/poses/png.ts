// Writes an 8-bit grey PNG. A canvas would write four channels, and change values on the way.

type Bytes = Uint8Array<ArrayBuffer>

const kCrcTable = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1
  return c
})

function crc32(bytes: Uint8Array): number {
  let crc = 0xffffffff
  for (const byte of bytes) crc = kCrcTable[(crc ^ byte) & 255] ^ (crc >>> 8)
  return ~crc >>> 0
}

/** Length, name, content, checksum. */
function chunk(name: string, content: Uint8Array): Bytes {
  const bytes = new Uint8Array(12 + content.length)
  const view = new DataView(bytes.buffer)
  view.setUint32(0, content.length)
  for (let i = 0; i < 4; ++i) bytes[4 + i] = name.charCodeAt(i)
  bytes.set(content, 8)
  view.setUint32(8 + content.length, crc32(bytes.subarray(4, 8 + content.length)))
  return bytes
}

/** The rows, each after a 0: 'not filtered', which packs masks best. */
function rowsOf(width: number, height: number, values: Uint8Array): Bytes {
  const rows = new Uint8Array((width + 1) * height)
  for (let y = 0; y < height; ++y)
    rows.set(values.subarray(y * width, (y + 1) * width), y * (width + 1) + 1)
  return rows
}

export async function greyPng(width: number, height: number, values: Uint8Array): Promise<Blob> {
  const head = new Uint8Array(13)
  const view = new DataView(head.buffer)
  view.setUint32(0, width)
  view.setUint32(4, height)
  head[8] = 8 // bits; the colour type 0 after it is grey
  const packer = new CompressionStream('deflate')
  const packed = new Blob([rowsOf(width, height, values)]).stream().pipeThrough(packer)
  const content = new Uint8Array(await new Response(packed).arrayBuffer())
  const magic = new Uint8Array([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a])
  const end = chunk('IEND', new Uint8Array())
  const parts = [magic, chunk('IHDR', head), chunk('IDAT', content), end]
  return new Blob(parts, { type: 'image/png' })
}
