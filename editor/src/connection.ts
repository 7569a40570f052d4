// The socket: requests with answers, events, packets; and finding the server again when it was away.

import { readPacket, writeUpload, type Json, type Packet, type ServerEvent, type TypedArray } from './protocol';
import { sentence } from './sentences';

/** A request that was refused; the message is a sentence for people. */
export class Refusal extends Error {
  constructor(readonly status: string, message: string) { super(message); }
}

type Answer = { resolve: (value: any) => void; reject: (reason: Error) => void };

export class Connection {
  onEvent: (event: ServerEvent) => void = () => {};
  onPacket: (packet: Packet) => void = () => {};
  /** open; lost: it ended just now; gone: nobody listens there; refused: somebody does, but lets this page not in. */
  onState: (state: 'open' | 'lost' | 'gone' | 'refused') => void = () => {};

  private socket: WebSocket | null = null;
  private waiting = new Map<number, Answer>();
  private next = 1;
  private tries = 0;

  constructor(private readonly token: string) { this.open(); }

  private open(): void {
    const socket = new WebSocket(`ws://${location.host}/socket?token=${encodeURIComponent(this.token)}`, 'pith');
    socket.binaryType = 'arraybuffer';
    let opened = false;
    socket.onopen = () => { opened = true; this.tries = 0; this.onState('open'); };
    socket.onmessage = (message) => this.receive(message.data);
    socket.onclose = () => {
      if (this.socket !== socket) return;
      for (const answer of this.waiting.values()) answer.reject(new Refusal('lost', 'The connection to pith was lost.'));
      this.waiting.clear();
      // A server that was there a moment ago and refuses has another token: this page is from an earlier run.
      this.onState(!opened && this.tries > 0 ? 'refused' : 'lost');
      this.tryAgain();
    };
    this.socket = socket;
  }

  /* Looks for the server after a while, longer every time. A socket does not say why it failed, so whether anybody
     listens is asked first. */
  private tryAgain(): void {
    setTimeout(async () => {
      if (await fetch('/', { cache: 'no-store' }).then(() => true, () => false)) return this.open();
      this.onState('gone');
      this.tryAgain();
    }, Math.min(250 * 2 ** this.tries++, 4000));
  }

  private receive(data: string | ArrayBuffer): void {
    if (typeof data !== 'string') {
      const packet = readPacket(data);
      if (packet.id !== undefined) this.take(packet.id)?.resolve(packet);
      else this.onPacket(packet);
      return;
    }
    const message = JSON.parse(data) as Json;
    if (message.event) this.onEvent(message as ServerEvent);
    else if (message.ok) this.take(message.id)?.resolve(message);
    else this.take(message.id)?.reject(new Refusal(message.status, sentence(message.message, message.status)));
  }

  private take(id: number): Answer | undefined {
    const answer = this.waiting.get(id);
    this.waiting.delete(id);
    return answer;
  }

  /** Sends a request; resolves with its answer (JSON, or a packet), rejects with a Refusal. */
  ask<T = Json>(what: string, keys: Json = {}): Promise<T> {
    return this.send((id) => JSON.stringify({ id, do: what, ...keys }));
  }

  /** Sends bytes, or arrays by their names, along with a request. */
  upload<T = Json>(what: string, keys: Json, values: Uint8Array | { [name: string]: TypedArray }): Promise<T> {
    return this.send((id) => writeUpload({ id, do: what, ...keys }, values));
  }

  private send<T>(make: (id: number) => string | ArrayBuffer): Promise<T> {
    return new Promise<T>((resolve, reject) => {
      if (this.socket?.readyState !== WebSocket.OPEN) {
        reject(new Refusal('lost', 'There is no connection to pith; it is being looked for.'));
        return;
      }
      const id = this.next++;
      this.waiting.set(id, { resolve, reject });
      this.socket.send(make(id));
    });
  }
}
