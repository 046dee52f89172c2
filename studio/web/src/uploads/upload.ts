// Sends files in pieces: a film is larger than one request.
import { ApiError, ask } from '../api'
import type { Item, Place } from './upload_model'

/** Small enough to be sent again after a fault. */
const kPiece_bytes = 8 * 2 ** 20

interface Answer {
  /** bytes that are there */
  sent: number
  /** its path in the project, when all of it is there */
  file: string
}

/** @returns its path in the project */
export async function sendFile(
  where: { place: Place; shot?: string },
  { file, name }: Item,
  told: (sent: number) => void,
  stopped: () => boolean = () => false,
): Promise<string> {
  for (let at = 0; !stopped(); ) {
    const words = { place: where.place, shot: where.shot ?? '', name, at: String(at), size: String(file.size) }
    const piece = file.slice(at, at + kPiece_bytes)
    const answer = await ask(`/api/upload?${new URLSearchParams(words)}`, { method: 'PUT', body: piece })
    const { sent, file: path } = (await answer.json()) as Answer
    told(sent)
    if (path) return path
    at = sent
  }
  throw new ApiError(400, `${name} was not sent to its end`)
}
